// The calibration that an Azure Kinect carries and that its recorder attaches to a file.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "plumbline/pinhole.h"
#include "plumbline/se3.h"

namespace plumbline {

struct KinectCalibration {
  Pinhole depth, color;  ///< color.width is 0 where the recording has no colour
  Distortion depth_distortion, color_distortion;
  SE3 color_from_depth;                            ///< metres
  std::optional<Eigen::Matrix3d> body_from_depth;  ///< axes of the accelerometer
};

/// `json` is the attached calibration.json. `depth_mode` is the recorder's name for it ("NFOV_UNBINNED", …); colour of
/// color_width × color_height, or 0. Throws Error for text that is no such calibration, a lens model that is not known,
/// a mode or size that the camera does not have, and a depth image whose size is not the mode's; `name` is the file's.
KinectCalibration parse_kinect_calibration(std::string_view json, std::string_view depth_mode, int depth_width,
                                           int depth_height, int color_width, int color_height,
                                           const std::string& name);

}  // namespace plumbline
