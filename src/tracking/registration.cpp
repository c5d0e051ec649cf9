#include "tracking/registration.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "backend/registration.h"
#include "plumbline/error.h"
#include "tracking/solver.h"

namespace plumbline {
namespace {

// The distribution of the pairs' distances: half-millimetre bins, below what a Kinect tells apart, as far as the widest
// gate of a preset (docs/method.md §4).
constexpr int kDistanceBins = 1000;
constexpr double kDistanceRange = 0.5;  // metres

// Beyond three usual gates a pair is a stranger, however far the seed is from the truth.
constexpr double kMaxGate = 0.3;  // metres

// Of a full image: with fewer matched pixels, noise decides the pose, however small the part of them that has depth.
constexpr int kMinInliers = 300;

// Condition number of the scaled normal equations above which a direction is left free: the images say nothing of it.
constexpr double kMaxCondition = 1e6;

/// σ(z) = 1.2 + 1.9 (z − 0.4)² mm (Nguyen, Izadi, Lovell 2012, axial), scaled to 1 at 1.5 m.
kernels::NoiseModel nguyen_noise() {
  constexpr double kBase = 1.2, kSlope = 1.9, kNearest = 0.4, kUnit = 1.5;
  constexpr double kAtUnit = kBase + kSlope * (kUnit - kNearest) * (kUnit - kNearest);
  return {static_cast<float>(kBase / kAtUnit), static_cast<float>(kSlope / kAtUnit), static_cast<float>(kNearest)};
}

/// Covariance of the camera's rotation and position out of the system's inverse: increments about the camera's own
/// centre, in the world's axes, so that turning does not move it.
Matrix6d pose_covariance(const Matrix6d& h, const SE3& world_from_model, const SE3& world_from_camera) {
  const SE3 world_from_centre(Eigen::Matrix3d::Identity(), world_from_camera.translation());
  const Matrix6d model_from_centre = (world_from_model.inverse() * world_from_centre).adjoint();
  const Matrix6d at_centre = model_from_centre.transpose() * h * model_from_centre;
  const Eigen::LDLT<Matrix6d> factors(at_centre);
  if (factors.info() != Eigen::Success || !factors.isPositive()) return Matrix6d::Zero();
  return factors.solve(Matrix6d::Identity());
}

LostReason judge(const TrackingResult& result, const RegistrationInput& input, const TrackingParameters& parameters) {
  if (result.inliers < kMinInliers || result.inlier_fraction < parameters.min_inlier_fraction ||
      result.inliers < parameters.min_matched * result.pairs)
    return LostReason::few_inliers;
  if (result.rank < 6 || !result.world_from_camera.is_finite()) return LostReason::singular;
  const SE3 step = input.world_from_camera_seed.inverse() * result.world_from_camera;
  if (step.translation().norm() > parameters.max_step_translation ||
      so3::angle(step.rotation()) > parameters.max_step_rotation.radians())
    return LostReason::implausible_step;
  return LostReason::none;
}

/// Fewer pixels at a coarse level hold the same fraction of the image.
int min_inliers_at(int level) { return std::max(6, kMinInliers >> (2 * level)); }

// A level of fewer columns has too few points to be better than the next finer one's start: with four levels of 640
// pixels the camera was lost three times as often as with three (docs/decisions/0010).
constexpr int kMinColumns = 64;

/// Where the number of iterations is not fixed, the finer levels make up for such a level.
bool is_too_coarse(const TrackingParameters& parameters, const DepthLevel& level) {
  return parameters.converged_step > 0 && level.camera.width < kMinColumns;
}

/// The finest level that iterates.
int finest_iterated_level(const TrackingParameters& parameters) {
  int level = parameters.finest_level;
  for (auto limit = parameters.iterations.rbegin(); limit != parameters.iterations.rend() && *limit == 0; ++limit)
    ++level;
  return level;
}

/// The levels that iterate, coarse to fine, and the images that they take.
class Levels {
 public:
  /// `registration` gets them.
  Levels(const DepthPyramid& live, const DepthPyramid& model, const TrackingParameters& parameters,
         kernels::Registration* registration) {
    const std::size_t missing = live.size() - model.size();  // finest levels that the model does not have
    int level = pyramid_levels(parameters) - 1;
    for (std::size_t i = 0; i < parameters.iterations.size(); ++i, --level) {
      const auto at = static_cast<std::size_t>(level);
      const int iterations = parameters.iterations[i];
      const bool is_left_out =
          iterations == 0 || (level > finest_iterated_level(parameters) && is_too_coarse(parameters, live[at]));
      if (is_left_out) continue;
      if (registration->level_count == kernels::kMaxLevels)
        throw Error("there are too many levels", "tracking.iterations", "Give eight at most.");
      const int pixels = live[at].camera.width * live[at].camera.height;
      kernels::RegistrationLevel& out = registration->levels[registration->level_count++];
      out.images = icp_input(live[at], model[at - missing]);
      if (parameters.median_filter) out.distances = live[at].pair_distances.view();
      out.information = registration_information(parameters, pixels);
      out.pixels = pixels;
      out.iterations = iterations;
      out.min_inliers = min_inliers_at(level);
      levels_.push_back({level, i});
    }
  }

  /// Of the pyramid.
  int level(int of_registration) const { return levels_[static_cast<std::size_t>(of_registration)].level; }

  /// Per entry of the parameters' iterations.
  std::vector<int> iterations(const kernels::RegistrationState& state, std::size_t entries) const {
    std::vector<int> made(entries, 0);
    for (std::size_t i = 0; i < levels_.size(); ++i) made[levels_[i].entry] = state.iterations[i];
    return made;
  }

 private:
  struct Place {
    int level;          ///< of the pyramid
    std::size_t entry;  ///< of the parameters' iterations
  };

  std::vector<Place> levels_;
};

IcpIteration traced(const kernels::RegistrationState& state, const IcpSums& sums, int level, int level_pixels,
                    const SE3& world_from_model) {
  IcpIteration trace;
  trace.level = level;
  trace.histogram = sums.histogram;
  trace.bin_width = sums.bin_width;
  trace.median_distance = sums.median_distance();
  trace.pairs = sums.pairs();
  trace.matched = state.inliers();
  trace.matched_fraction = static_cast<double>(state.inliers()) / level_pixels;
  trace.rms = state.rms();
  trace.step = Vector6d(state.step);
  trace.world_from_camera = world_from_model * state.model_from_live;
  return trace;
}

/// What the final iteration says, in pixels of the full image.
void summarise(const kernels::RegistrationState& state, int level, TrackingResult* result) {
  using namespace kernels::icp_sum;
  result->pairs = static_cast<int>(state.slots[kPairs]) << (2 * level);
  result->inliers = state.inliers() << (2 * level);
  result->inlier_fraction = state.inliers() / std::max(1.0, state.slots[kWithDepth]);
  result->rms = state.rms();
  result->median_distance = state.median_distance;
  result->rank = state.rank;
  result->condition = condition(Matrix6d(state.h));
}

}  // namespace

std::string_view to_string(TrackingStatus status) {
  switch (status) {
    case TrackingStatus::initialised:
      return "initialised";
    case TrackingStatus::tracked:
      return "tracked";
    case TrackingStatus::provisional:
      return "provisional";
    case TrackingStatus::lost:
      return "lost";
  }
  return "unknown";
}

std::string_view to_string(LostReason reason) {
  switch (reason) {
    case LostReason::none:
      return "";
    case LostReason::no_depth:
      return "no depth";
    case LostReason::few_inliers:
      return "few inliers";
    case LostReason::singular:
      return "singular";
    case LostReason::implausible_step:
      return "implausible step";
    case LostReason::unknown_place:
      return "unknown place";
    case LostReason::unconfirmed:
      return "unconfirmed";
  }
  return "unknown";
}

int pyramid_levels(const TrackingParameters& parameters) {
  return parameters.finest_level + static_cast<int>(parameters.iterations.size());
}

kernels::RegistrationRules registration_rules(const TrackingParameters& parameters) {
  kernels::RegistrationRules rules;
  rules.distance_gate = parameters.distance_gate;
  rules.widest_gate = kMaxGate;
  rules.gate_per_median = parameters.gate_per_median;
  rules.cos_normal_gate = static_cast<float>(std::cos(parameters.normal_gate.radians()));
  if (parameters.depth_weights) rules.noise = nguyen_noise();
  if (parameters.huber > 0) rules.huber = static_cast<float>(parameters.huber);
  rules.bins = kDistanceBins;
  rules.bins_per_metre = static_cast<float>(kDistanceBins / kDistanceRange);
  rules.median_filter = parameters.median_filter;
  rules.median_band = parameters.median_band;
  rules.max_condition = kMaxCondition;
  rules.converged_step = parameters.converged_step;
  rules.converged_after = parameters.converged_after;
  rules.max_iterations = parameters.max_iterations;
  // Counting costs a tenth of a pass, and else only the frame's final median is told.
  rules.every_distribution =
      parameters.gate_per_median > 0 || parameters.median_filter || parameters.converged_after > 0;
  return rules;
}

TrackingResult register_frame(const Backend& backend, const DepthPyramid& live, const DepthPyramid& model,
                              const RegistrationInput& input, const TrackingParameters& parameters) {
  kernels::Registration registration;
  registration.rules = registration_rules(parameters);
  registration.terms = input.terms;
  registration.world_from_model = input.world_from_model;
  const Levels levels(live, model, parameters, &registration);

  const SE3 seed = input.world_from_model.inverse() * input.world_from_camera_seed;
  kernels::RegistrationState state;
  if (input.trace == nullptr) {
    state = backend.iterate(registration, seed);
  } else {
    registration.rules.every_distribution = true;
    state =
        run_passes(backend, registration, seed, [&](const kernels::RegistrationState& s, const IcpSums& sums, int i) {
          input.trace->push_back(
              traced(s, sums, levels.level(i), registration.levels[i].pixels, registration.world_from_model));
        });
  }

  TrackingResult result;
  result.iterations = levels.iterations(state, parameters.iterations.size());
  if (registration.level_count > 0) summarise(state, levels.level(state.next.level), &result);
  result.world_from_camera = (input.world_from_model * state.model_from_live).normalized();
  if (result.rank == 6)
    result.pose_covariance = pose_covariance(Matrix6d(state.h), input.world_from_model, result.world_from_camera);
  result.reason = judge(result, input, parameters);
  result.status = result.reason == LostReason::none ? TrackingStatus::tracked : TrackingStatus::lost;
  return result;
}

Image<std::uint8_t> explain_pixels(const Backend& backend, const DepthPyramid& live, const DepthPyramid& model,
                                   const SE3& world_from_model, const TrackingResult& result,
                                   const TrackingParameters& parameters) {
  const DepthLevel& level = live[static_cast<std::size_t>(parameters.finest_level)];
  const Plane<std::uint8_t> use(level.camera.width, level.camera.height, backend);
  kernels::IcpInput in = icp_input(level, model.front());
  const kernels::RegistrationRules rules = registration_rules(parameters);
  rules.set_gates(world_from_model.inverse() * result.world_from_camera, result.median_distance, &in);
  if (rules.median_filter) rules.set_band(result.median_distance, &in);
  backend.run(kernels::ExplainPixels{in, use.view()});
  return download(backend, use);
}

}  // namespace plumbline
