// An inertial and magnetic sensor that rides on the camera, with the errors of a chip that fuses its own readings.
//
// Frames: E earth (x east, y north, z up), B the sensor's body, C the camera. Units: radians, m/s², microtesla.
#pragma once

#include <cstdint>
#include <vector>

#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "sim/depth_camera.h"

namespace plumbline::sim {

struct OrientationSensorOptions {
  double rate = 100;        ///< Hz
  double latency = 0;       ///< seconds by which a reading's stamp is late
  double clock_offset = 0;  ///< seconds by which the sensor's clock is ahead at the start
  double clock_drift = 0;   ///< seconds gained a second
  Eigen::Matrix3d body_from_camera = Eigen::Matrix3d::Identity();
  Eigen::Vector3d lever_arm = Eigen::Vector3d::Zero();  ///< metres, the sensor in the camera's frame
  Eigen::Matrix3d earth_from_world = Eigen::Matrix3d::Identity();
  double tilt_error = 0, heading_error = 0;  ///< radians, amplitudes of the systematic error; the paper's chip: 3°, 10°
  int harmonics = 3;
  double orientation_noise = 0;                           ///< radians rms about each axis, white
  double gyroscope_noise = 0;                             ///< rad/s rms, white
  double gyroscope_bias = 0;                              ///< rad/s rms of each axis at the start
  double gyroscope_bias_walk = 0;                         ///< rad/s per √s
  double accelerometer_noise = 0;                         ///< m/s² rms, white
  double magnetometer_noise = 0;                          ///< µT rms, white
  Eigen::Vector3d disturbance = Eigen::Vector3d::Zero();  ///< µT, earth axes, added to the earth's field …
  double disturbance_begin = 0, disturbance_end = 0;      ///< … between these times, seconds, with soft ends
  std::uint64_t seed = 1;
};

constexpr double kGravity = 9.80665;  ///< m/s²
/// Of central Europe: 20 µT to the north, 44 µT down.
Eigen::Vector3d earth_magnetic_field();

struct InertialSample {
  Nanoseconds time = 0;             ///< the stamp, of the sensor's clock
  Eigen::Matrix3d earth_from_body;  ///< as the sensor reports it
  Eigen::Vector3d angular_rate;     ///< rad/s, body axes, bias and noise included
  Eigen::Vector3d specific_force;   ///< m/s², body axes: acceleration minus gravity
  Eigen::Vector3d magnetic_field;   ///< µT, body axes
};

/// Readings over 0 ≤ t ≤ duration of a camera's motion, whose time 0 has the stamp `start`; a few more before it, at
/// rest, where latency or clock would leave the beginning without any. Throws Error for options out of range.
std::vector<InertialSample> simulate_sensor(const PoseAt& world_from_camera, double duration, Nanoseconds start,
                                            const OrientationSensorOptions& options);

}  // namespace plumbline::sim
