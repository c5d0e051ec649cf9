// Raw readings of an inertial sensor.
//
// Frame: B the sensor's body, whose axes all three sensors share.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "plumbline/orientation.h"
#include "plumbline/time.h"

namespace plumbline {

struct ImuSample {
  Nanoseconds time = 0;
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();  ///< rad/s, body axes; zero without a gyroscope
  /// m/s², body axes: at rest 9.8 upwards; zero without an accelerometer.
  Eigen::Vector3d specific_force = Eigen::Vector3d::Zero();
  std::optional<Eigen::Vector3d> magnetic_field = {};  ///< µT, body axes; empty where there is no reading
};

/// The rate and the force between two samples, linearly; without the magnetic field.
inline ImuSample interpolated(const ImuSample& a, const ImuSample& b, Nanoseconds time) {
  const double share = static_cast<double>(time - a.time) / static_cast<double>(b.time - a.time);
  ImuSample sample;
  sample.time = time;
  sample.angular_rate = a.angular_rate + share * (b.angular_rate - a.angular_rate);
  sample.specific_force = a.specific_force + share * (b.specific_force - a.specific_force);
  return sample;
}

/// Ordered by time, each stamp once.
struct ImuRecording {
  std::vector<ImuSample> samples;
  bool has_gyroscope = true;
  bool has_accelerometer = true;
  bool has_magnetometer = false;
  /// Orientations of an optical system where the file has them, earth_from_body; only those that are to be evaluated.
  std::vector<OrientationSample> reference = {};
  /// The body axes are those of the Kinect's own accelerometer (TUM's `accelerometer.txt`).
  bool kinect_axes = false;
};

}  // namespace plumbline
