// What a sequence delivers.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "plumbline/export.h"
#include "plumbline/image.h"
#include "plumbline/imu.h"
#include "plumbline/time.h"

namespace plumbline {

/// One depth frame, undistorted, with its colour image where the sequence has one.
struct Frame {
  int index = 0;              ///< position in the sequence, counted before --stride
  Nanoseconds time = 0;       ///< of the *depth* image
  DepthImage depth;           ///< raw readings, 0 = none
  double depth_scale = 5000;  ///< readings per metre
  ColorImage color;           ///< empty, or registered to the depth image (same size and intrinsics)
  /// Measured orientation of the camera at `time`, earth axes (x east, y north, z up); empty without a sensor.
  std::optional<Eigen::Matrix3d> earth_from_camera = {};
  /// Readings of a gyroscope and an accelerometer, camera axes, ordered by time: those from the previous frame to this
  /// one, and some before and after where they are known already, as the sensor's clock may be off; empty without such
  /// a sensor.
  std::vector<ImuSample> inertial = {};
};

/// Readings of a depth image in metres, `depth_scale` each metre; 0 where a value is not finite, not positive, or
/// beyond 65535 readings. O(pixels).
PLUMBLINE_EXPORT DepthImage readings_of(const Image<float>& metres, double depth_scale);

}  // namespace plumbline
