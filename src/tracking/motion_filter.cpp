#include "tracking/motion_filter.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace plumbline {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Places of the parts of the error state.
constexpr int kTheta = 0, kPosition = 3, kVelocity = 6, kGyroscopeBias = 9, kAccelerometerBias = 12, kGravity = 15;

constexpr double kStandardGravity = 9.81;  // m/s²
// Longest time between two readings over which the rate is taken to be constant.
constexpr double kMaxReadingGap = 0.1;  // seconds

// Standard deviations at the start: of a pose that defines the world, of a hand's speed, of a sensor's biases, and of
// gravity by one reading of a hand that moves: across it and along it.
constexpr double kStartPose = 1e-3, kStartSpeed = 0.5, kStartGyroscopeBias = 0.01, kStartAccelerometerBias = 0.1,
                 kStartGravityAcross = 0.5, kStartGravityAlong = 0.03;
// Random walks per √s: of a rotation by its gyroscope (and by its scale, per rad/s), and of the biases.
constexpr double kRotationWalk = 0.003, kScaleWalk = 0.003, kGyroscopeBiasWalk = 1e-4, kAccelerometerBiasWalk = 3e-3;

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
  if (readings.empty()) return;
  rate_ = readings.back().angular_rate;
  if (parameters_.accelerometer) set_gravity(readings.back().specific_force);
}

void MotionFilter::set_gravity(const Vector3d& specific_force) {
  if (!(specific_force.norm() > 1)) return;
  has_gravity_ = true;
  const Vector3d up = (world_from_camera_.rotation() * specific_force).normalized();
  gravity_ = -kStandardGravity * up;
  const double along = kStartGravityAlong * kStartGravityAlong, across = kStartGravityAcross * kStartGravityAcross;
  block(covariance_, kGravity, kGravity) = across * Matrix3d::Identity() + (along - across) * up * up.transpose();
}

void MotionFilter::propagate(const std::vector<ImuSample>& readings, Nanoseconds time) {
  is_inertial_ = false;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const ImuSample& next = readings[i];
    const ImuSample& before = readings[i > 0 ? i - 1 : 0];
    const Nanoseconds until = std::min(next.time, time);
    if (until <= time_) continue;
    const double seconds = to_seconds(until - time_);
    if (i == 0 || to_seconds(next.time - before.time) > kMaxReadingGap) {
      step_steadily(seconds);
    } else {
      if (!has_gravity_ && parameters_.accelerometer) set_gravity(before.specific_force);
      step((before.angular_rate + next.angular_rate) / 2, (before.specific_force + next.specific_force) / 2, seconds);
      is_inertial_ = true;
    }
    time_ = until;
  }
  if (time_ < time) step_steadily(to_seconds(time - time_));
  time_ = time;
}

void MotionFilter::step(const Vector3d& angular_rate, const Vector3d& specific_force, double seconds) {
  const double dt = seconds;
  const Matrix3d rotation = world_from_camera_.rotation();
  rate_ = angular_rate - gyroscope_bias_;
  const Vector3d force = rotation * (specific_force - accelerometer_bias_);
  const Vector3d acceleration = has_gravity_ ? Vector3d(force + gravity_) : Vector3d(Vector3d::Zero());

  const Vector3d position = world_from_camera_.translation() + velocity_ * dt + 0.5 * dt * dt * acceleration;
  velocity_ += dt * acceleration;
  world_from_camera_ = SE3(Matrix3d(rotation * so3::exp(Vector3d(dt * rate_))), position).normalized();

  Covariance f = Covariance::Identity();
  block(f, kTheta, kGyroscopeBias) = -dt * rotation;
  block(f, kPosition, kVelocity) = dt * Matrix3d::Identity();
  if (has_gravity_) {
    block(f, kVelocity, kTheta) = -dt * hat(force);
    block(f, kVelocity, kAccelerometerBias) = -dt * rotation;
    block(f, kVelocity, kGravity) = dt * Matrix3d::Identity();
  }
  covariance_ = f * covariance_ * f.transpose();
  add_variance(covariance_, kTheta, std::hypot(kRotationWalk, kScaleWalk * rate_.norm()), dt);
  add_variance(covariance_, kVelocity, has_gravity_ ? parameters_.acceleration_sigma : parameters_.steady_speed_sigma,
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
  add_variance(covariance_, kTheta, parameters_.steady_turn_sigma, seconds);
  add_variance(covariance_, kVelocity, parameters_.steady_speed_sigma, seconds);
}

void MotionFilter::correct(const SE3& world_from_camera, const Matrix6d& covariance) {
  const Matrix6d predicted = pose_covariance();
  Vector6d innovation;
  innovation.head<3>() = so3::log(Matrix3d(world_from_camera.rotation() * world_from_camera_.rotation().transpose()));
  innovation.tail<3>() = world_from_camera.translation() - world_from_camera_.translation();
  const Eigen::LDLT<Matrix6d> factors(predicted);
  const Eigen::Matrix<double, 6, 18> gain = factors.solve(covariance_.topRows<6>());
  covariance_ -= gain.transpose() * (predicted - covariance) * gain;
  covariance_ = ((covariance_ + covariance_.transpose()) / 2).eval();

  velocity_ += gain.middleCols<3>(kVelocity).transpose() * innovation;
  gyroscope_bias_ += gain.middleCols<3>(kGyroscopeBias).transpose() * innovation;
  accelerometer_bias_ += gain.middleCols<3>(kAccelerometerBias).transpose() * innovation;
  gravity_ += gain.middleCols<3>(kGravity).transpose() * innovation;
  if (!is_inertial_ && time_ > previous_corrected_time_)
    rate_ = so3::log(Matrix3d(previous_corrected_.rotation().transpose() * world_from_camera.rotation())) /
            to_seconds(time_ - previous_corrected_time_);
  world_from_camera_ = previous_corrected_ = world_from_camera;
  previous_corrected_time_ = time_;
}

}  // namespace plumbline
