#include "sim/orientation_sensor.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/random.h"
#include "plumbline/error.h"
#include "sensor/error_model.h"

namespace plumbline::sim {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr const char* kOrientationSensorWhere = "orientation sensor";

// 301 is the systematic error's.
enum SensorStream : std::uint64_t { kOrientation = 302, kGyroscope, kBias, kAccelerometer, kMagnetometer };

Vector3d normal3(std::uint64_t key, std::uint64_t counter) {
  return {normal_at(key, 3 * counter), normal_at(key, 3 * counter + 1), normal_at(key, 3 * counter + 2)};
}

void validate(const OrientationSensorOptions& o, double duration) {
  if (!(o.rate > 0) || !(duration >= 0))
    throw Error("the rate or the duration is not positive", kOrientationSensorWhere, "give Hz, seconds");
  if (!(o.latency >= 0) || !std::isfinite(o.clock_offset) || !(std::abs(o.clock_drift) < 0.1))
    throw Error("the latency or the clock is out of range", kOrientationSensorWhere,
                "give seconds, and a drift below 0.1");
  for (const double sigma : {o.orientation_noise, o.gyroscope_noise, o.gyroscope_bias, o.gyroscope_bias_walk,
                             o.accelerometer_noise, o.magnetometer_noise})
    if (!(sigma >= 0)) throw Error("a noise is negative", kOrientationSensorWhere, "give standard deviations");
}

/// The sensor's true motion, differentiated numerically: the paths are twice continuously differentiable.
class BodyMotion {
 public:
  BodyMotion(const PoseAt& world_from_camera, double duration, const OrientationSensorOptions& o)
      : world_from_camera_(world_from_camera),
        duration_(duration),
        earth_from_world_(o.earth_from_world, Vector3d::Zero()),
        camera_from_body_(o.body_from_camera.transpose(), o.lever_arm) {}

  SE3 earth_from_body(double t) const { return earth_from_world_ * world_from_camera_(t) * camera_from_body_; }

  /// rad/s, body axes.
  Vector3d angular_rate(double t) const {
    if (t < 0 || t > duration_) return Vector3d::Zero();
    const double middle = inside(t);
    return so3::log(earth_from_body(middle - kStep).rotation().transpose() *
                    earth_from_body(middle + kStep).rotation()) /
           (2 * kStep);
  }

  /// m/s², earth axes.
  Vector3d acceleration(double t) const {
    if (t < 0 || t > duration_) return Vector3d::Zero();
    const double middle = inside(t);
    return (earth_from_body(middle - kStep).translation() - 2 * earth_from_body(middle).translation() +
            earth_from_body(middle + kStep).translation()) /
           (kStep * kStep);
  }

 private:
  static constexpr double kStep = 5e-4;  ///< seconds
  double inside(double t) const {
    return std::clamp(t, std::min(kStep, duration_ / 2), std::max(duration_ - kStep, duration_ / 2));
  }

  const PoseAt& world_from_camera_;
  double duration_;
  SE3 earth_from_world_, camera_from_body_;
};

/// 0 outside an interval, 1 within, with raised cosines over a quarter of a second.
double soft_interval(double t, double begin, double end) {
  if (!(end > begin)) return 0;
  const double ramp = std::min(0.25, (end - begin) / 2),
               share = std::clamp(std::min(t - begin, end - t) / ramp, 0.0, 1.0);
  return 0.5 - 0.5 * std::cos(std::numbers::pi * share);
}

/// How far a disturbance turns a compass, radians about up, counter-clockwise. A body that believes the disturbed field
/// to be north reports itself turned the other way.
double heading_shift(const Vector3d& field, const Vector3d& disturbed) {
  return std::remainder(std::atan2(disturbed.y(), disturbed.x()) - std::atan2(field.y(), field.x()),
                        2 * std::numbers::pi);
}

}  // namespace

Vector3d earth_magnetic_field() { return {0, 20, -44}; }

std::vector<InertialSample> simulate_sensor(const PoseAt& world_from_camera, double duration, Nanoseconds start,
                                            const OrientationSensorOptions& o) {
  validate(o, duration);
  const BodyMotion motion(world_from_camera, duration, o);
  const SystematicError systematic({o.tilt_error, o.tilt_error, o.heading_error}, o.harmonics, o.seed);
  const auto key = [&](SensorStream name) { return stream(o.seed, name); };
  const Vector3d gravity(0, 0, -kGravity), field = earth_magnetic_field();
  const int before = static_cast<int>(std::ceil((o.latency + std::max(0.0, o.clock_offset)) * o.rate));
  const int after = static_cast<int>(std::ceil((duration + std::max(0.0, -o.clock_offset)) * o.rate));
  Vector3d bias = o.gyroscope_bias * normal3(key(kBias), 0);
  std::vector<InertialSample> samples;
  for (int k = -before; k <= after; ++k) {
    const auto number = static_cast<std::uint64_t>(k + before);
    const double t = k / o.rate;
    const Matrix3d earth_from_body = motion.earth_from_body(t).rotation(),
                   body_from_earth = earth_from_body.transpose();
    const Vector3d local_field = field + soft_interval(t, o.disturbance_begin, o.disturbance_end) * o.disturbance;
    const Matrix3d turned = so3::exp(Vector3d(0, 0, -heading_shift(field, local_field))) * earth_from_body;
    InertialSample s;
    s.time = start + from_seconds(t + o.latency + o.clock_offset + o.clock_drift * (t + o.latency));
    s.earth_from_body = so3::exp(o.orientation_noise * normal3(key(kOrientation), number)) *
                        so3::exp(systematic.at(earth_from_body)) * turned;
    s.angular_rate = motion.angular_rate(t) + bias + o.gyroscope_noise * normal3(key(kGyroscope), number);
    s.specific_force = body_from_earth * (motion.acceleration(t) - gravity) +
                       o.accelerometer_noise * normal3(key(kAccelerometer), number);
    s.magnetic_field = body_from_earth * local_field + o.magnetometer_noise * normal3(key(kMagnetometer), number);
    samples.push_back(s);
    bias += o.gyroscope_bias_walk / std::sqrt(o.rate) * normal3(key(kBias), number + 1);
  }
  return samples;
}

}  // namespace plumbline::sim
