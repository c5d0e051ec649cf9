// What an orientation sensor delivers.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>

#include "plumbline/time.h"

namespace plumbline::capture {

/// How well the chip knows its own sensors: 0 (not at all) … 3 (fully).
struct CalibrationStatus {
  int system = 0, gyroscope = 0, accelerometer = 0, magnetometer = 0;
  bool operator==(const CalibrationStatus&) const = default;
};

struct RawReading {
  Eigen::Vector3d angular_rate;    ///< rad/s, body axes
  Eigen::Vector3d specific_force;  ///< m/s², body axes: acceleration minus gravity
  Eigen::Vector3d magnetic_field;  ///< µT, body axes
};

struct ImuReading {
  Nanoseconds time = 0;        ///< monotonic
  Eigen::Vector4d quaternion;  ///< x y z w, unit: earth_from_body as the chip has it
  std::optional<RawReading> raw;
  CalibrationStatus calibration;
};

}  // namespace plumbline::capture
