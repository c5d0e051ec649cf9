// What `plumbline calibrate` found out about an orientation sensor, as a TOML file.
#pragma once

#include <string>
#include <vector>

#include "plumbline/export.h"
#include "plumbline/orientation.h"

namespace plumbline {

struct OrientationCalibration {
  Eigen::Matrix3d body_from_camera = Eigen::Matrix3d::Identity();
  Eigen::Vector3d mounting_sd = Eigen::Vector3d::Zero();  ///< radians, about the camera's axes x, y, z
  double time_offset = 0;                                 ///< seconds, to be added to the sensor's stamps
  double time_offset_sd = 0;                              ///< seconds
  OrientationConvention convention = {};                  ///< that the readings were read with
};

/// `comments` are written at the top, a line each. Throws Error if the file cannot be written whole.
PLUMBLINE_EXPORT void write_orientation_calibration(const std::string& path, const OrientationCalibration& calibration,
                                                    const std::vector<std::string>& comments);

/// Throws Error with file and line for a file that is no TOML, lacks one of the values, or has
/// one out of range.
PLUMBLINE_EXPORT OrientationCalibration read_orientation_calibration(const std::string& path);

}  // namespace plumbline
