// Frame-to-model registration, coarse to fine: from a seed to a pose, and why it is believed.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "backend/maps.h"
#include "core/parameters.h"
#include "core/se3.h"
#include "kernels/registration.h"
#include "tracking/priors.h"

namespace plumbline {

enum class TrackingStatus { initialised, tracked, lost };
enum class LostReason { none, no_depth, few_inliers, singular, implausible_step };
std::string_view to_string(TrackingStatus status);
std::string_view to_string(LostReason reason);

/// What one iteration saw and did, for plots of distance distributions and convergence.
struct IcpIteration {
  int level = 0;
  std::vector<std::int32_t> histogram;  ///< pairs per distance bin; the last entry counts those beyond the range
  double bin_width = 0;                 ///< metres
  double median_distance = 0;           ///< metres
  int pairs = 0;                        ///< in the distribution
  int matched = 0;                      ///< of these, used
  double matched_fraction = 0;          ///< of the level's pixels
  double rms = 0;                       ///< point-to-plane, metres
  Vector6d step = Vector6d::Zero();     ///< (ω, v), left increment of model_from_live: radians, metres
  SE3 world_from_camera;                ///< after the step
};

/// What the tracker starts from. The default is the plain KinectFusion of METHOD.md §1.
struct TrackingInput {
  SE3 world_from_model;                        ///< camera pose from which the model was predicted
  SE3 world_from_camera_seed;                  ///< initial guess
  kernels::Priors priors;                      ///< what is known besides; none: registration alone
  std::vector<IcpIteration>* trace = nullptr;  ///< if given, gets every iteration
};

/// What came out of one frame.
struct TrackingResult {
  TrackingStatus status = TrackingStatus::lost;
  LostReason reason = LostReason::none;
  SE3 world_from_camera;
  std::vector<int> iterations;  ///< per level, coarse to fine
  int pairs = 0;                ///< pixels of the last iteration that meet the model, however far away
  int inliers = 0;              ///< of these, matched ones
  double inlier_fraction = 0;   ///< of the pixels of the last level that have depth
  double rms = 0;               ///< point-to-plane residual of the matched pixels, metres
  double median_distance = 0;   ///< of the associated pairs, metres, at the histogram's resolution
  int rank = 0;                 ///< of the last 6×6 system, 6 when all directions are held
  double condition = 0;         ///< of the last 6×6 system after scaling
  /// Of the position, priors included, world frame, metres²; zero if the last system was singular.
  Eigen::Matrix3d position_covariance = Eigen::Matrix3d::Zero();
};

/// Levels of both pyramids needed: finest_level + number of entries of iterations.
int pyramid_levels(const TrackingParameters& parameters);

/// What the parameters ask of every pass and step.
kernels::RegistrationRules registration_rules(const TrackingParameters& parameters);

/// Registers `live` against `model` (METHOD.md §1, "association" and "minimisation"; §3 and §4). The model's
/// pyramid may lack the finest levels, which are not registered.
TrackingResult track(const Backend& backend, const DepthPyramid& live, const DepthPyramid& model,
                     const TrackingInput& input, const TrackingParameters& parameters);

}  // namespace plumbline
