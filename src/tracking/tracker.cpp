#include "tracking/tracker.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "tracking/solver.h"

namespace plumbline {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180;

/// σ(z) = 1.2 + 1.9 (z − 0.4)² mm (Nguyen, Izadi, Lovell 2012, axial), scaled to 1 at 1.5 m.
kernels::NoiseModel nguyen_noise() {
  constexpr double kBase = 1.2, kSlope = 1.9, kNearest = 0.4, kUnit = 1.5;
  constexpr double kAtUnit = kBase + kSlope * (kUnit - kNearest) * (kUnit - kNearest);
  return {static_cast<float>(kBase / kAtUnit), static_cast<float>(kSlope / kAtUnit), static_cast<float>(kNearest)};
}

/// What one iteration found.
struct Iteration {
  IcpSums sums;
  Solution solution;
  Matrix6d h;  ///< of the system, left increments of model_from_live
};

/// The prior's equations are in left increments of world_from_camera, the registration's in left increments of
/// model_from_live; they differ by the adjoint of world_from_model.
void add_prior(const Prior& prior, const SE3& world_from_model, const SE3& model_from_live, const Association& found,
               Matrix6d* h, Vector6d* b) {
  const NormalEquations term = prior.evaluate(world_from_model * model_from_live, found);
  const Matrix6d world_from_model_increment = world_from_model.adjoint();
  *h += world_from_model_increment.transpose() * term.h * world_from_model_increment;
  *b += world_from_model_increment.transpose() * term.b;
}

/// One pyramid level of one frame.
class Level {
 public:
  Level(const Backend& backend, const DepthLevel& live, const DepthLevel& model, const TrackingInput& input,
        const TrackingParameters& parameters)
      : backend_(&backend), live_(&live), model_(&model), input_(&input), parameters_(&parameters) {
    if (parameters.median_filter)
      distances_ = {live.camera.width, live.camera.height, [&](std::size_t bytes) { return backend.allocate(bytes); }};
  }

  int pixels() const { return live_->camera.width * live_->camera.height; }

  /// Association and solve, and the step that follows from it. `median` is the last known one, metres.
  Iteration iterate(double median, bool with_distribution, SE3* model_from_live) const {
    Iteration iteration{associate(median, with_distribution, *model_from_live), {}, {}};
    const double information = registration_information(*parameters_, pixels());
    Matrix6d h = information * iteration.sums.hessian();
    Vector6d b = information * iteration.sums.gradient();
    if (input_->prior != nullptr)
      add_prior(*input_->prior, input_->world_from_model, *model_from_live,
                {iteration.sums.inliers(), pixels(), information}, &h, &b);
    iteration.h = h;
    iteration.solution = solve(h, b, parameters_->max_condition);
    *model_from_live = (SE3::exp(iteration.solution.step) * *model_from_live).normalized();
    return iteration;
  }

  /// One pass over the pixels. With the median filter it is made with the band around the last median and corrected for
  /// that of its own: the bands differ by little, and so do the pixels to look at again.
  IcpSums associate(double median, bool with_distribution, const SE3& model_from_live) const {
    kernels::IcpInput in = icp_input(*live_, *model_);
    set_gates(*parameters_, model_from_live, median, &in);
    if (!with_distribution) in.bins = 0;
    if (!parameters_->median_filter) return backend_->reduce(kernels::IcpReduce{in});
    set_band(*parameters_, median, &in);
    IcpSums sums = backend_->reduce(kernels::IcpReduce{in, distances_.view()});
    kernels::IcpCorrection correction{in, in.band_low, in.band_high, read_only(distances_)};
    set_band(*parameters_, sums.median_distance(), &correction.in);
    if (correction.in.band_low != in.band_low) backend_->correct(correction, &sums);
    return sums;
  }

 private:
  const Backend* backend_;
  const DepthLevel *live_, *model_;
  const TrackingInput* input_;
  const TrackingParameters* parameters_;
  Plane<float> distances_;  ///< of every pixel's pair, metres
};

/// When a level is through with its iterations.
class LevelEnd {
 public:
  LevelEnd(const TrackingParameters& parameters, int limit) : parameters_(&parameters), limit_(limit) {}

  /// Whether the next iteration may be the level's last.
  bool is_near() const { return made_ + 1 >= limit_; }

  bool reached(const Iteration& last) {
    ++made_;
    return median_stands_still(last.sums) || (made_ >= limit_ && (made_ >= longest() || !still_moves(last.solution)));
  }

 private:
  /// The median's bin has not changed over so many successive iterations (METHOD.md §4).
  bool median_stands_still(const IcpSums& sums) {
    if (parameters_->converged_after == 0) return false;
    const int bin = sums.median_bin();
    same_ = bin == last_bin_ ? same_ + 1 : 1;
    last_bin_ = bin;
    return same_ >= parameters_->converged_after;
  }

  int longest() const { return parameters_->converged_step > 0 ? parameters_->max_iterations : limit_; }

  /// What is at the usual distance of a scene still moves.
  bool still_moves(const Solution& solution) const {
    constexpr double kUsualDistance = 1.5;  // metres
    const double moved = kUsualDistance * solution.step.head<3>().norm() + solution.step.tail<3>().norm();
    return moved >= parameters_->converged_step;
  }

  const TrackingParameters* parameters_;
  int limit_, made_ = 0, same_ = 0, last_bin_ = -1;
};

/// Covariance of the camera's position out of the system's inverse: increments about the camera's own centre, in the
/// world's axes, so that turning does not move it.
Eigen::Matrix3d position_covariance(const Matrix6d& h, const SE3& world_from_model, const SE3& world_from_camera) {
  const SE3 world_from_centre(Eigen::Matrix3d::Identity(), world_from_camera.translation());
  const Matrix6d model_from_centre = (world_from_model.inverse() * world_from_centre).adjoint();
  const Matrix6d at_centre = model_from_centre.transpose() * h * model_from_centre;
  const Eigen::LDLT<Matrix6d> factors(at_centre);
  if (factors.info() != Eigen::Success || !factors.isPositive()) return Eigen::Matrix3d::Zero();
  return factors.solve(Matrix6d::Identity()).bottomRightCorner<3, 3>();
}

LostReason judge(const TrackingResult& result, const TrackingInput& input, const TrackingParameters& parameters) {
  if (result.inliers < parameters.min_inliers || result.inlier_fraction < parameters.min_inlier_fraction ||
      result.inliers < parameters.min_matched * result.pairs)
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
  result->pairs = last.sums.pairs() << (2 * level);
  result->inliers = last.sums.inliers() << (2 * level);  // in pixels of the full image
  result->inlier_fraction = static_cast<double>(last.sums.inliers()) / std::max(1, last.sums.with_depth());
  result->rms = last.sums.rms();
  result->median_distance = last.sums.median_distance();
  result->rank = last.solution.rank;
  result->condition = last.solution.condition;
}

/// Whether the distances' distribution guides the registration or is looked at after every iteration. Counting costs a
/// tenth of a pass, and else only the frame's last median is told.
bool needs_every_distribution(const TrackingParameters& parameters, const TrackingInput& input) {
  return parameters.gate_per_median > 0 || parameters.median_filter || parameters.converged_after > 0 ||
         input.trace != nullptr;
}

// A level of fewer columns has too few points to be better than the next finer one's start: with four levels of 640
// pixels the camera was lost three times as often as with three (docs/design.md).
constexpr int kFewestColumns = 64;

/// Where the number of iterations is not fixed, the finer levels make up for such a level.
bool is_too_coarse(const TrackingParameters& parameters, const DepthLevel& level) {
  return parameters.converged_step > 0 && level.camera.width < kFewestColumns;
}

/// The finest level that iterates.
int last_level(const TrackingParameters& parameters) {
  int level = parameters.finest_level;
  for (auto limit = parameters.iterations.rbegin(); limit != parameters.iterations.rend() && *limit == 0; ++limit)
    ++level;
  return level;
}

IcpIteration traced(const Iteration& iteration, int level, int level_pixels, const SE3& world_from_camera) {
  const IcpSums& sums = iteration.sums;
  IcpIteration trace;
  trace.level = level;
  trace.histogram = sums.histogram;
  trace.bin_width = sums.bin_width;
  trace.median_distance = sums.median_distance();
  trace.pairs = sums.pairs();
  trace.matched = sums.inliers();
  trace.matched_fraction = static_cast<double>(sums.inliers()) / level_pixels;
  trace.rms = sums.rms();
  trace.step = iteration.solution.step;
  trace.world_from_camera = world_from_camera;
  return trace;
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

void set_gates(const TrackingParameters& parameters, const SE3& model_from_live, double last_median,
               kernels::IcpInput* in) {
  in->model_from_live = to_kernel(model_from_live);
  const double widest = std::max(parameters.distance_gate, parameters.widest_gate);
  in->distance_gate =
      static_cast<float>(std::clamp(parameters.gate_per_median * last_median, parameters.distance_gate, widest));
  in->cos_normal_gate = static_cast<float>(std::cos(parameters.normal_gate * kRadiansPerDegree));
  in->band_low = 0;
  in->band_high = std::numeric_limits<float>::max();
  if (parameters.depth_weights) in->noise = nguyen_noise();
  if (parameters.huber > 0) in->huber = static_cast<float>(parameters.huber);
  in->bins = parameters.histogram_bins;
  in->bins_per_metre = static_cast<float>(parameters.histogram_bins / parameters.histogram_range);
}

void set_band(const TrackingParameters& parameters, double median_distance, kernels::IcpInput* in) {
  in->band_low = static_cast<float>(median_distance - parameters.median_band);
  in->band_high = static_cast<float>(median_distance + parameters.median_band);
}

TrackingResult track(const Backend& backend, const DepthPyramid& live, const DepthPyramid& model,
                     const TrackingInput& input, const TrackingParameters& parameters) {
  TrackingResult result;
  SE3 model_from_live = input.world_from_model.inverse() * input.world_from_camera_seed;
  Matrix6d last_h = Matrix6d::Zero();
  const std::size_t missing = live.size() - model.size();  // finest levels that the model does not have
  const bool every_distribution = needs_every_distribution(parameters, input);
  int level = pyramid_levels(parameters) - 1;
  for (const int limit : parameters.iterations) {
    const auto at = static_cast<std::size_t>(level);
    const Level registration(backend, live[at], model[at - missing], input, parameters);
    LevelEnd end(parameters, limit);
    result.iterations.push_back(0);
    const bool is_left_out = limit == 0 || (level > last_level(parameters) && is_too_coarse(parameters, live[at]));
    for (bool done = is_left_out; !done;) {
      const bool is_last = level == last_level(parameters),
                 with_distribution = every_distribution || (is_last && end.is_near());
      const SE3 before = model_from_live;
      const Iteration iteration = registration.iterate(result.median_distance, with_distribution, &model_from_live);
      ++result.iterations.back();
      summarise(iteration, level, &result);
      last_h = iteration.h;
      if (input.trace != nullptr)
        input.trace->push_back(
            traced(iteration, level, registration.pixels(), input.world_from_model * model_from_live));
      const bool nothing_to_hold = iteration.sums.inliers() < min_inliers_at(parameters, level);
      done = end.reached(iteration) || nothing_to_hold;
      if (done && is_last && !with_distribution)  // sooner than expected
        result.median_distance = registration.associate(0, true, before).median_distance();
    }
    --level;
  }
  result.world_from_camera = (input.world_from_model * model_from_live).normalized();
  if (result.rank == 6)
    result.position_covariance = position_covariance(last_h, input.world_from_model, result.world_from_camera);
  result.reason = judge(result, input, parameters);
  result.status = result.reason == LostReason::none ? TrackingStatus::tracked : TrackingStatus::lost;
  return result;
}

}  // namespace plumbline
