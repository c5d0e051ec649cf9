#include "tracking/tracker.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "tracking/solver.h"

namespace plumbline {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180;

/// What one iteration found.
struct Iteration {
  IcpSums sums;
  Solution solution;
};

/// The prior's equations are in left increments of world_from_camera, the registration's in left increments of
/// model_from_live; they differ by the adjoint of world_from_model.
void add_prior(const Prior& prior, const SE3& world_from_model, const SE3& model_from_live, const IcpSums& sums,
               int level_pixels, Matrix6d* h, Vector6d* b) {
  const NormalEquations term = prior.evaluate(world_from_model * model_from_live, sums.inliers(), level_pixels);
  const Matrix6d world_from_model_increment = world_from_model.adjoint();
  *h += world_from_model_increment.transpose() * term.h * world_from_model_increment;
  *b += world_from_model_increment.transpose() * term.b;
}

/// One association and solve at one level, and the step that follows from it.
Iteration iterate(const Backend& backend, const DepthLevel& live, const DepthLevel& model, const TrackingInput& input,
                  const TrackingParameters& parameters, SE3* model_from_live) {
  kernels::IcpInput in = icp_input(live, model);
  set_gates(parameters, *model_from_live, &in);
  Iteration iteration{backend.reduce(kernels::IcpReduce{in}), {}};

  Matrix6d h = iteration.sums.hessian();
  Vector6d b = iteration.sums.gradient();
  if (input.prior != nullptr)
    add_prior(*input.prior, input.world_from_model, *model_from_live, iteration.sums,
              live.camera.width * live.camera.height, &h, &b);
  iteration.solution = solve(h, b, parameters.max_condition);
  *model_from_live = (SE3::exp(iteration.solution.step) * *model_from_live).normalized();
  return iteration;
}

LostReason judge(const TrackingResult& result, const TrackingInput& input, const TrackingParameters& parameters) {
  if (result.inliers < parameters.min_inliers || result.inlier_fraction < parameters.min_inlier_fraction)
    return LostReason::few_inliers;
  if (result.rank < 6 || !result.world_from_camera.is_finite()) return LostReason::singular;
  const SE3 step = input.world_from_camera_seed.inverse() * result.world_from_camera;
  if (step.translation().norm() > parameters.max_step_translation ||
      so3::angle(step.rotation()) > parameters.max_step_rotation * kRadiansPerDegree)
    return LostReason::implausible_step;
  return LostReason::none;
}

/// Fewer pixels at a coarse level hold the same fraction of the image.
int min_inliers_at(const TrackingParameters& parameters, int level) {
  return std::max(6, parameters.min_inliers >> (2 * level));
}

void summarise(const Iteration& last, int level, TrackingResult* result) {
  result->inliers = last.sums.inliers() << (2 * level);  // in pixels of the full image
  result->inlier_fraction = static_cast<double>(last.sums.inliers()) / std::max(1, last.sums.with_depth());
  result->rms = last.sums.inliers() > 0 ? std::sqrt(last.sums.squares() / last.sums.inliers()) : 0;
  result->median_distance = last.sums.median_distance();
  result->rank = last.solution.rank;
  result->condition = last.solution.condition;
}

}  // namespace

std::string_view to_string(TrackingStatus status) {
  switch (status) {
    case TrackingStatus::initialised:
      return "initialised";
    case TrackingStatus::tracked:
      return "tracked";
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
  }
  return "unknown";
}

int pyramid_levels(const TrackingParameters& parameters) {
  return parameters.finest_level + static_cast<int>(parameters.iterations.size());
}

void set_gates(const TrackingParameters& parameters, const SE3& model_from_live, kernels::IcpInput* in) {
  in->model_from_live = to_kernel(model_from_live);
  in->distance_gate = static_cast<float>(parameters.distance_gate);
  in->cos_normal_gate = static_cast<float>(std::cos(parameters.normal_gate * kRadiansPerDegree));
  in->band_low = 0;
  in->band_high = std::numeric_limits<float>::max();
  in->bins = parameters.histogram_bins;
  in->bins_per_metre = static_cast<float>(parameters.histogram_bins / parameters.histogram_range);
}

TrackingResult track(const Backend& backend, const DepthPyramid& live, const DepthPyramid& model,
                     const TrackingInput& input, const TrackingParameters& parameters) {
  TrackingResult result;
  SE3 model_from_live = input.world_from_model.inverse() * input.world_from_camera_seed;
  int level = pyramid_levels(parameters) - 1;
  for (const int limit : parameters.iterations) {
    const auto at = static_cast<std::size_t>(level);
    if (input.convergence != nullptr) input.convergence->start_level();
    result.iterations.push_back(0);
    while (result.iterations.back() < limit) {
      const Iteration iteration = iterate(backend, live[at], model[at], input, parameters, &model_from_live);
      ++result.iterations.back();
      summarise(iteration, level, &result);
      if (iteration.sums.inliers() < min_inliers_at(parameters, level)) break;  // nothing left to hold on to
      if (input.convergence != nullptr && input.convergence->converged(iteration.sums)) break;
    }
    --level;
  }
  result.world_from_camera = (input.world_from_model * model_from_live).normalized();
  result.reason = judge(result, input, parameters);
  result.status = result.reason == LostReason::none ? TrackingStatus::tracked : TrackingStatus::lost;
  return result;
}

}  // namespace plumbline
