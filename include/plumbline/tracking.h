// What came of registering one frame: the values that a run reports.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "plumbline/export.h"
#include "plumbline/se3.h"

namespace plumbline {

/// `provisional`: the place was recognised after an interruption, and is not yet confirmed by other views of it. Such a
/// frame is not fused, and its pose may be taken back.
enum class TrackingStatus { initialised, tracked, provisional, lost };
/// `unknown_place`: after an interruption no known place was recognised. `unconfirmed`: one was, and the frames after
/// it contradicted it.
enum class LostReason { none, no_depth, few_inliers, singular, implausible_step, unknown_place, unconfirmed };
/// Whether a frame has a pose to go on from.
constexpr bool has_pose(TrackingStatus status) {
  return status == TrackingStatus::initialised || status == TrackingStatus::tracked;
}
PLUMBLINE_EXPORT std::string_view to_string(TrackingStatus status);
PLUMBLINE_EXPORT std::string_view to_string(LostReason reason);

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

/// What came out of one frame.
struct TrackingResult {
  TrackingStatus status = TrackingStatus::lost;
  LostReason reason = LostReason::none;
  SE3 world_from_camera;
  std::vector<int> iterations;  ///< per level, coarse to fine
  int pairs = 0;                ///< pixels of the final iteration that meet the model, however far away
  int inliers = 0;              ///< of these, matched ones
  double inlier_fraction = 0;   ///< of the pixels of the final level that have depth
  double rms = 0;               ///< point-to-plane residual of the matched pixels, metres
  double median_distance = 0;   ///< of the associated pairs, metres, at the histogram's resolution
  int rank = 0;                 ///< of the final 6×6 system, 6 when all directions are held
  double condition = 0;         ///< of the final 6×6 system after scaling
  /// Of (θ, t), what is known besides the images included; world axes, radians² and metres²; zero if the final system
  /// was singular.
  Matrix6d pose_covariance = Matrix6d::Zero();
};

/// What became of the sensor in one frame.
enum class OrientationUse {
  off,         ///< no parameter asks for it, or the sequence has no sensor
  missing,     ///< no reading for this frame
  first,       ///< the reading that ties the earth to the world
  used,        ///< as a seed, as a term, or both
  distrusted,  ///< it disagrees with what was tracked over the latest frames
  dropped      ///< the frame could only be tracked without it, or clearly better
};
PLUMBLINE_EXPORT std::string_view to_string(OrientationUse use);

}  // namespace plumbline
