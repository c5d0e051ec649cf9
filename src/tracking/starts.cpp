#include "tracking/starts.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace plumbline {

double agreement(const TrackingResult& result) {
  constexpr double kMismatch = 1.5;
  if (result.inliers == 0) return 0;
  return result.inlier_fraction * (1 - kMismatch * (result.pairs - result.inliers) / result.inliers);
}

// Frames of fr1/rpy that were registered rightly had 0.11 and more even in its nearly empty views; with every third or
// fifth frame and no sensor, those that were not had less than 0, from the first wrong one on.
bool is_doubtful(const TrackingResult& result, double previous_agreement) {
  constexpr double kDoubt = 0.1, kFall = 0.1;
  return result.status == TrackingStatus::lost || agreement(result) < std::min(kDoubt, previous_agreement - kFall);
}

std::vector<SE3> turned_about(const SE3& seed, double step) {
  constexpr int kAxes = 8, kRings = 3;
  std::vector<SE3> turned;
  for (int ring = 1; ring <= kRings; ++ring)
    for (int i = 0; i < kAxes; ++i) {
      const double azimuth = 2 * std::numbers::pi * i / kAxes;
      const Eigen::Vector3d axis(std::cos(azimuth), std::sin(azimuth), 0);
      turned.emplace_back(seed.rotation() * so3::exp(Eigen::Vector3d(ring * step * axis)), seed.translation());
    }
  return turned;
}

TrackingParameters coarse(TrackingParameters parameters) {
  if (parameters.iterations.size() > 1) parameters.iterations.back() = 0;
  return parameters;
}

TrackingParameters without_limits(TrackingParameters parameters) {
  parameters.max_step_translation = 1e3;
  parameters.max_step_rotation = 180;
  return parameters;
}

TrackingParameters far_reaching(const TrackingParameters& parameters, int levels) {
  TrackingParameters far = without_limits(patient(parameters));
  for (auto i = static_cast<std::size_t>(levels); i < far.iterations.size(); ++i) far.iterations[i] = 0;
  far.distance_gate = 0.4;
  far.normal_gate = 40;
  far.gate_per_median = 0;
  far.converged_step = 0.002;
  far.max_iterations = 20;
  far.huber = 0.05;
  return far;
}

TrackingParameters patient(TrackingParameters parameters) {
  parameters.max_iterations *= 4;
  parameters.converged_step /= 5;
  return parameters;
}

}  // namespace plumbline
