// A camera that is turned about, as a tracker would see it, with a sensor of unknown mounting and clock on it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "calibration/mounting_calibration.h"
#include "core/random.h"
#include "plumbline/angles.h"
#include "plumbline/orientation.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"
#include "sim/orientation_sensor.h"

namespace plumbline::test {

struct RecordingOptions {
  std::uint64_t seed = 1;
  double duration = 10, rate = 30;            ///< seconds, Hz
  Eigen::Vector3d reach = {40, 45, 50};       ///< degrees either way about x, y, z of the camera
  double tempo = 1;                           ///< factor on the speed
  double tremor = 0.6;                        ///< degrees rms of a hand
  bool ideal = false;                         ///< no systematic error
  double tilt_error = 3, heading_error = 10;  ///< degrees
  int harmonics = 3;
  bool exact_poses = false;
};

struct Recording {
  Trajectory camera;  ///< as tracked
  std::vector<OrientationSample> sensor;
  Eigen::Matrix3d body_from_camera;
  double time_offset;  ///< seconds, to be added to the sensor's stamps

  OrientationStream stream() const { return {sensor, {}}; }
};

inline Eigen::Vector3d normals(std::uint64_t key, std::uint64_t n) {
  return {normal_at(key, 3 * n), normal_at(key, 3 * n + 1), normal_at(key, 3 * n + 2)};
}

/// world_from_camera: z up, looking horizontally to begin with, and each angle a sum of two slow sines and a tremor.
class Dance {
 public:
  explicit Dance(const RecordingOptions& o) : o_(o) {
    Random random(stream(o.seed, 1));
    heading_ = random.uniform(-3, 3);
    for (auto& axis : sines_)
      for (std::size_t i = 0; i < axis.size(); ++i)
        axis[i] = {random.uniform(0.12, 0.3) * (i < 2 ? 1 : 12), random.uniform(0, 2 * std::numbers::pi)};
  }

  SE3 at(double t) const {
    Eigen::Vector3d angles;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto sine = [&](std::size_t i) {
        return std::sin(2 * std::numbers::pi * sines_[axis][i].first * o_.tempo * t + sines_[axis][i].second);
      };
      const auto a = static_cast<Eigen::Index>(axis);
      angles[a] = kRadiansPerDegree * (o_.reach[a] * (0.7 * sine(0) + 0.3 * sine(1)) + o_.tremor * (sine(2) + sine(3)));
    }
    const auto turn = [](double angle, Eigen::Index axis) { return so3::exp(angle * Eigen::Vector3d::Unit(axis)); };
    return {turn(heading_, 2) * turn(-std::numbers::pi / 2, 0) * turn(angles[1], 1) * turn(angles[0], 0) *
                turn(angles[2], 2),
            Eigen::Vector3d::Zero()};
  }

 private:
  RecordingOptions o_;
  double heading_;
  std::array<std::array<std::pair<double, double>, 4>, 3> sines_;  // Hz, phase
};

/// Errors as our tracker has them: white, slowly varying within a view, and drifting.
inline Trajectory tracked(const Dance& dance, const RecordingOptions& o, Nanoseconds start) {
  const std::uint64_t white = stream(o.seed, 2), slow = stream(o.seed, 3), drift = stream(o.seed, 4);
  const double keep = std::exp(-1 / (0.3 * o.rate));
  Eigen::Vector3d lag = 0.1 * normals(slow, 0), walk = Eigen::Vector3d::Zero();
  Trajectory camera;
  for (int i = 0; i < static_cast<int>(o.duration * o.rate); ++i) {
    const auto n = static_cast<std::uint64_t>(i);
    lag = keep * lag + 0.1 * std::sqrt(1 - keep * keep) * normals(slow, n + 1);
    walk += 0.1 / std::sqrt(o.rate) * normals(drift, n);
    Eigen::Vector3d error = kRadiansPerDegree * (0.05 * normals(white, n) + lag + walk);
    if (o.exact_poses) error.setZero();
    const SE3 pose = dance.at(i / o.rate);
    camera.push_back({start + from_seconds(i / o.rate), {so3::exp(error) * pose.rotation(), pose.translation()}});
  }
  // The tracker's world is the first camera's.
  const SE3 first = camera.front().world_from_camera.inverse();
  for (StampedPose& pose : camera) pose.world_from_camera = first * pose.world_from_camera;
  return camera;
}

inline Recording record(const RecordingOptions& o) {
  constexpr Nanoseconds kStart = 1'305'031'000'000'000'000;
  Random random(stream(o.seed, 5));
  Recording r;
  const Dance dance(o);
  r.camera = tracked(dance, o, kStart);
  r.body_from_camera = Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal())
                           .normalized()
                           .toRotationMatrix();
  sim::OrientationSensorOptions sensor;
  sensor.latency = random.uniform(0, 0.06);
  sensor.clock_offset = random.uniform(-0.4, 0.4);
  r.time_offset = -(sensor.latency + sensor.clock_offset);
  sensor.body_from_camera = r.body_from_camera;
  sensor.earth_from_world = so3::exp(Eigen::Vector3d(0, 0, random.uniform(-3, 3)));
  sensor.tilt_error = o.ideal ? 0 : o.tilt_error * kRadiansPerDegree;
  sensor.heading_error = o.ideal ? 0 : o.heading_error * kRadiansPerDegree;
  sensor.harmonics = o.harmonics;
  sensor.seed = o.seed;
  for (const sim::InertialSample& sample : sim::simulate_sensor(
           [&](double t) { return dance.at(std::clamp(t, 0.0, o.duration)); }, o.duration, kStart, sensor))
    r.sensor.push_back({sample.time, sample.earth_from_body});
  return r;
}

}  // namespace plumbline::test
