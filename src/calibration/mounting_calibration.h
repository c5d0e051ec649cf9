// How a sensor is mounted on a camera and how its clock differs, from the camera's path and the sensor's readings, and
// whether the motion was such that this can be known.
//
// Frames: E earth, B the sensor's body, W the world of the camera's path, C the camera. The model of a frame at time t
// is
//
//     E_R_B(t − offset) = exp(e(Q)) Q,   Q = exp(x(t)) E_R_W · W_R_C(t) · (B_R_C)ᵀ
//
// with a slow drift x(t) between both (the tracker's, or of a heading without a magnetometer) and the sensor's
// systematic error e (`periodic_error`). That error is no detail: a heading that errs by ±10° over a turn stretches the
// turns about the vertical by up to a half, however short they are, so that turns alone mislead by degrees.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "calibration/hand_eye.h"
#include "calibration/time_offset.h"
#include "plumbline/trajectory.h"
#include "sensor/orientation_stream.h"

namespace plumbline {

struct CalibrationOptions {
  OffsetSearch search;
  /// What may remain unknown (standard deviations) before the motion counts as too poor: radians, seconds.
  double worst_mounting = 0.005;
  double worst_offset = 0.003;
};

/// Of the first that applies; in the order of the list.
enum class MotionVerdict {
  good,
  too_short,        ///< too few frames with a reading
  no_rotation,      ///< the camera hardly turned
  one_axis,         ///< it turned about one axis only
  does_not_fit,     ///< the sensor does not turn as the camera does: another recording, another convention
  mounting_unsure,  ///< rotation about two axes, but not enough of it for this sensor
  offset_unsure     ///< too slow to tell the time
};
std::string_view to_string(MotionVerdict verdict);

struct MountingCalibration {
  MotionVerdict verdict = MotionVerdict::too_short;
  std::string advice;  ///< what to do, in words; empty if the verdict is good

  Eigen::Matrix3d body_from_camera = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< radians², rotation about the camera's axes x, y, z
  double time_offset = 0;                                ///< seconds, to be added to the sensor's stamps
  double time_offset_sd = 0;                             ///< seconds

  Eigen::Matrix3d tsai_lenz = Eigen::Matrix3d::Identity(), park_martin = Eigen::Matrix3d::Identity();
  double tsai_lenz_residual = 0, park_martin_residual = 0;  ///< radians rms over `turns` turns
  std::size_t turns = 0;
  double first_offset = 0, correlation = 0;  ///< of the angular speeds: seconds, and how well they agree

  std::size_t frames = 0;                                ///< with a reading, used for the refinement
  double duration = 0;                                   ///< seconds from the first to the last of them
  double residual = 0;                                   ///< radians rms of a frame after the refinement
  double redundancy = 1;                                 ///< successive residuals that tell no more than one
  double drift = 0;                                      ///< radians from the least to the largest x(t)
  Eigen::Vector3d systematic = Eigen::Vector3d::Zero();  ///< radians: largest error found about east, north, up
  Eigen::Vector3d spread =
      Eigen::Vector3d::Zero();  ///< radians rms of the turning about its principal axes, descending
  Eigen::Matrix3d spread_axes = Eigen::Matrix3d::Identity();  ///< those axes in the camera's frame, as columns
  double speed = 0;                                           ///< rad/s rms

  /// Standard deviations of the mounting along the eigenvectors of its information, radians, ascending.
  Eigen::Vector3d sd_along() const;
  /// The camera's axis about which the mounting is known worst.
  Eigen::Vector3d worst_axis() const;
};

/// `camera` is world_from_camera, ordered by time; `sensor` has neither mounting nor time offset. Closed forms from
/// turns of some degrees, then everything at once by Levenberg-Marquardt with a robust loss (Ceres), where the scales
/// of noise, drift and systematic error follow from the data (evidence approximation: MacKay, "Bayesian interpolation",
/// 1992). The standard deviations count correlated residuals once, and contain what drift and systematic error leave
/// open. Throws Error if the two do not overlap in time at any offset searched.
MountingCalibration calibrate_mounting(const Trajectory& camera, const OrientationStream& sensor,
                                       const CalibrationOptions& options = {});

/// "x (nodding)" and the like: the nearest of the camera's axes, or the numbers where it is none of them.
std::string axis_text(const Eigen::Vector3d& axis);

}  // namespace plumbline
