#include "tracking/motion_filter.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace plumbline {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Places of the parts of the error state.
constexpr int kTheta = 0, kPosition = 3, kVelocity = 6, kGyroscopeBias = 9, kAccelerometerBias = 12, kGravity = 15,
              kLateness = 18;

constexpr double kStandardGravity = 9.81;  // m/s²
// Longest time between two readings over which the rate is taken to be constant.
constexpr double kMaxReadingGap = 0.1;  // seconds
// Readings are kept for so long, as the sensor's clock may be off by up to the other.
constexpr double kMemory = 0.5, kMaxLateness = 0.15;  // seconds

// Standard deviations at the start: of a pose that defines the world, of a hand's speed, of a sensor's biases, and of
// gravity by one reading of a hand that moves: across it and along it.
constexpr double kStartPose = 1e-3, kStartSpeed = 0.5, kStartGyroscopeBias = 0.01, kStartAccelerometerBias = 0.1,
                 kStartGravityAcross = 0.5, kStartGravityAlong = 0.03, kStartLateness = 0.03;
// What a hand changes of its motion, per √s: radians without a gyroscope, m/s without an accelerometer.
constexpr double kSteadyTurn = 0.3, kSteadySpeed = 1.5;
constexpr double kMaxGyroscopeBias = 0.05;  // rad/s
// Random walks per √s: of a rotation by its gyroscope (and by its scale, per rad/s), and of the biases.
constexpr double kRotationWalk = 0.003, kScaleWalk = 0.003, kGyroscopeBiasWalk = 1e-4, kAccelerometerBiasWalk = 3e-3;

// What lies between two readings is not seen: of a motion at a hand's frequency the straight line between them misses
// this part.
double missed_between(double seconds) {
  constexpr double kHand = 2 * std::numbers::pi * 2;  // rad/s
  return kHand * kHand * seconds * seconds / 12;
}

bool is_finite(const ImuSample& reading) {
  return reading.angular_rate.allFinite() && reading.specific_force.allFinite();
}

const ImuSample& nearest_to(Nanoseconds time, const std::vector<ImuSample>& readings) {
  return *std::min_element(readings.begin(), readings.end(), [&](const ImuSample& a, const ImuSample& b) {
    return std::abs(a.time - time) < std::abs(b.time - time);
  });
}

using Block = Eigen::Block<MotionFilter::Covariance, 3, 3>;
Block block(MotionFilter::Covariance& m, int row, int column) { return m.block<3, 3>(row, column); }

void add_variance(MotionFilter::Covariance& m, int at, double sigma, double seconds) {
  block(m, at, at).diagonal().array() += sigma * sigma * seconds;
}

}  // namespace

void MotionFilter::start(const SE3& world_from_camera, Nanoseconds time, const std::vector<ImuSample>& readings) {
  *this = MotionFilter(parameters_);
  is_started_ = true;
  time_ = previous_corrected_time_ = time;
  world_from_camera_ = previous_corrected_ = world_from_camera;
  add_variance(covariance_, kTheta, kStartPose, 1);
  add_variance(covariance_, kPosition, kStartPose, 1);
  add_variance(covariance_, kVelocity, kStartSpeed, 1);
  add_variance(covariance_, kGyroscopeBias, kStartGyroscopeBias, 1);
  add_variance(covariance_, kAccelerometerBias, kStartAccelerometerBias, 1);
  covariance_(kLateness, kLateness) = kStartLateness * kStartLateness;
  if (readings.empty()) return;
  remember(readings);
  if (readings_.empty()) return;
  const ImuSample& nearest = nearest_to(time, readings_);
  rate_ = nearest.angular_rate;
  if (parameters_.accelerometer) set_gravity(nearest.specific_force);
}

void MotionFilter::set_gravity(const Vector3d& specific_force) {
  if (!(specific_force.norm() > 1)) return;
  has_gravity_ = true;
  const Vector3d up = (world_from_camera_.rotation() * specific_force).normalized();
  gravity_ = -kStandardGravity * up;
  const double along = kStartGravityAlong * kStartGravityAlong, across = kStartGravityAcross * kStartGravityAcross;
  block(covariance_, kGravity, kGravity) = across * Matrix3d::Identity() + (along - across) * up * up.transpose();
}

void MotionFilter::remember(const std::vector<ImuSample>& readings) {
  const Nanoseconds oldest = time_ - from_seconds(kMemory);
  std::erase_if(readings_, [&](const ImuSample& reading) { return reading.time < oldest; });
  for (const ImuSample& reading : readings)
    if (is_finite(reading) && (readings_.empty() || reading.time > readings_.back().time)) readings_.push_back(reading);
}

void MotionFilter::propagate(const std::vector<ImuSample>& readings, Nanoseconds time) {
  is_inertial_ = false;
  if (!readings.empty()) follow_readings(readings, time);
  if (time_ < time) step_steadily(to_seconds(time - time_));
  time_ = time;
}

void MotionFilter::follow_readings(const std::vector<ImuSample>& readings, Nanoseconds time) {
  remember(readings);
  const Nanoseconds late = from_seconds(lateness_);
  for (std::size_t i = 0; i + 1 < readings_.size(); ++i) {
    const ImuSample &a = readings_[i], &b = readings_[i + 1];
    const Nanoseconds from = std::max(a.time - late, time_), to = std::min(b.time - late, time);
    if (from >= to || to_seconds(b.time - a.time) > kMaxReadingGap) continue;
    if (from > time_) step_steadily(to_seconds(from - time_));
    if (!has_gravity_ && parameters_.accelerometer) set_gravity(a.specific_force);
    step(interpolated(a, b, from + late), interpolated(a, b, to + late), missed_between(to_seconds(b.time - a.time)));
    time_ = to;
    is_inertial_ = true;
  }
}

void MotionFilter::step(const ImuSample& from, const ImuSample& to, double missed) {
  const double dt = to_seconds(to.time - from.time);
  const Matrix3d rotation = world_from_camera_.rotation();
  rate_ = (from.angular_rate + to.angular_rate) / 2 - gyroscope_bias_;
  const Vector3d force = rotation * ((from.specific_force + to.specific_force) / 2 - accelerometer_bias_);
  const Vector3d acceleration = has_gravity_ ? Vector3d(force + gravity_) : Vector3d(Vector3d::Zero());

  const Vector3d position = world_from_camera_.translation() + velocity_ * dt + 0.5 * dt * dt * acceleration;
  velocity_ += dt * acceleration;
  world_from_camera_ = SE3(Matrix3d(rotation * so3::exp(Vector3d(dt * rate_))), position).normalized();

  Covariance f = Covariance::Identity();
  block(f, kTheta, kGyroscopeBias) = -dt * rotation;
  // Readings of a time δτ later: the rate, and the force, of the end in exchange for that of the beginning.
  f.block<3, 1>(kTheta, kLateness) = rotation * (to.angular_rate - from.angular_rate);
  block(f, kPosition, kVelocity) = dt * Matrix3d::Identity();
  if (has_gravity_) {
    block(f, kVelocity, kTheta) = -dt * hat(force);
    block(f, kVelocity, kAccelerometerBias) = -dt * rotation;
    block(f, kVelocity, kGravity) = dt * Matrix3d::Identity();
    f.block<3, 1>(kVelocity, kLateness) = rotation * (to.specific_force - from.specific_force);
  }
  covariance_ = f * covariance_ * f.transpose();
  add_variance(covariance_, kTheta, std::hypot(kRotationWalk, std::max(kScaleWalk, missed) * rate_.norm()), dt);
  add_variance(covariance_, kVelocity,
               has_gravity_ ? std::hypot(parameters_.acceleration_sigma, missed * acceleration.norm()) : kSteadySpeed,
               dt);
  add_variance(covariance_, kGyroscopeBias, kGyroscopeBiasWalk, dt);
  add_variance(covariance_, kAccelerometerBias, kAccelerometerBiasWalk, dt);
}

/// The rate and the velocity go on, with what a hand may change of them.
void MotionFilter::step_steadily(double seconds) {
  const Vector3d position = world_from_camera_.translation() + velocity_ * seconds;
  world_from_camera_ =
      SE3(Matrix3d(world_from_camera_.rotation() * so3::exp(Vector3d(seconds * rate_))), position).normalized();
  Covariance f = Covariance::Identity();
  block(f, kPosition, kVelocity) = seconds * Matrix3d::Identity();
  covariance_ = f * covariance_ * f.transpose();
  add_variance(covariance_, kTheta, kSteadyTurn, seconds);
  add_variance(covariance_, kVelocity, kSteadySpeed, seconds);
}

double MotionFilter::rotation_surprise(const SE3& world_from_camera, const Matrix6d& covariance) const {
  const Matrix6d predicted = pose_covariance(), information = covariance.inverse();
  const Eigen::LDLT<Matrix6d> images(information - predicted.inverse());
  if (images.info() != Eigen::Success || !images.isPositive()) return 0;
  const Matrix6d images_covariance = images.solve(Matrix6d::Identity());
  const Vector6d pull = images_covariance * (information * pose_difference(world_from_camera, world_from_camera_));
  const Matrix3d expected = (predicted + images_covariance).topLeftCorner<3, 3>();
  const double surprise = pull.head<3>().dot(expected.inverse() * pull.head<3>());
  return std::isfinite(surprise) ? surprise : 0;
}

void MotionFilter::correct(const SE3& world_from_camera, const Matrix6d& covariance) {
  const Matrix6d predicted = pose_covariance();
  const Vector6d innovation = pose_difference(world_from_camera, world_from_camera_);
  const Eigen::LDLT<Matrix6d> factors(predicted);
  const Eigen::Matrix<double, 6, 19> gain = factors.solve(covariance_.topRows<6>());
  covariance_ -= gain.transpose() * (predicted - covariance) * gain;
  covariance_ = ((covariance_ + covariance_.transpose()) / 2).eval();

  velocity_ += gain.middleCols<3>(kVelocity).transpose() * innovation;
  gyroscope_bias_ += gain.middleCols<3>(kGyroscopeBias).transpose() * innovation;
  // A bias that no such chip has is a sensor that does not fit: it must not be explained away.
  gyroscope_bias_ = gyroscope_bias_.cwiseMax(-kMaxGyroscopeBias).cwiseMin(kMaxGyroscopeBias);
  accelerometer_bias_ += gain.middleCols<3>(kAccelerometerBias).transpose() * innovation;
  lateness_ = std::clamp(lateness_ + gain.col(kLateness).dot(innovation), -kMaxLateness, kMaxLateness);
  gravity_ += gain.middleCols<3>(kGravity).transpose() * innovation;
  if (!is_inertial_ && time_ > previous_corrected_time_)
    rate_ = so3::log(Matrix3d(previous_corrected_.rotation().transpose() * world_from_camera.rotation())) /
            to_seconds(time_ - previous_corrected_time_);
  world_from_camera_ = previous_corrected_ = world_from_camera;
  previous_corrected_time_ = time_;
}

}  // namespace plumbline
