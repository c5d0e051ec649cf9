// What an inertial sensor measures, before it is made into an orientation.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "core/frame.h"
#include "core/time.h"

namespace plumbline {

/// One reading, body axes. A part that was not measured is NaN.
struct ImuReading {
  static Eigen::Vector3d none() { return Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()); }

  Nanoseconds time = 0;
  Eigen::Vector3d angular_rate = none();    ///< rad/s
  Eigen::Vector3d specific_force = none();  ///< m/s²: acceleration minus gravity, so that it points up at rest
  Eigen::Vector3d magnetic_field = none();  ///< any unit, always the same
};

/// Ordered by time.
struct ImuRecording {
  std::vector<ImuReading> readings;
  bool has_gyroscope = false, has_magnetometer = false;
  /// Orientations of an optical system where the file has them, earth_from_body; only those that are to be evaluated.
  std::vector<OrientationSample> reference;
  /// The body axes are those of the Kinect's own accelerometer (TUM's `accelerometer.txt`).
  bool kinect_axes = false;
};

}  // namespace plumbline
