#include "core/se3.h"

#include <cmath>

namespace plumbline {
namespace {

constexpr double kSmallAngle = 1e-4;  // below it the series' next term is under 1e-17

/// The three coefficients of Rodrigues' formula and its integral: sin θ/θ, (1−cos θ)/θ², (θ−sin θ)/θ³.
struct Rodrigues {
  double a, b, c;
};

Rodrigues rodrigues(double theta) {
  const double t2 = theta * theta;
  if (theta < kSmallAngle) return {1 - t2 / 6, 0.5 - t2 / 24, 1.0 / 6 - t2 / 120};
  const double half = std::sin(theta / 2) / theta;  // 1 − cos θ = 2 sin²(θ/2): no cancellation
  return {std::sin(theta) / theta, 2 * half * half,
          theta < 0.05 ? 1.0 / 6 - t2 / 120 + t2 * t2 / 5040 - t2 * t2 * t2 / 362880
                       : (theta - std::sin(theta)) / (t2 * theta)};
}

}  // namespace

Eigen::Matrix3d hat(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

namespace so3 {

Eigen::Matrix3d exp(const Eigen::Vector3d& omega) {
  const auto [a, b, c] = rodrigues(omega.norm());
  const Eigen::Matrix3d w = hat(omega);
  return Eigen::Matrix3d::Identity() + a * w + b * w * w;
}

Eigen::Vector3d log(const Eigen::Matrix3d& rotation) {
  // By the quaternion: well conditioned at every angle, π included.
  Eigen::Quaterniond q(rotation);
  q.normalize();
  if (q.w() < 0) q.coeffs() *= -1;
  const double s = q.vec().norm();
  if (s < kSmallAngle) return q.vec() * (2 / q.w() * (1 - s * s / (3 * q.w() * q.w())));
  return q.vec() * (2 * std::atan2(s, q.w()) / s);
}

Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& omega) {
  const auto [a, b, c] = rodrigues(omega.norm());
  const Eigen::Matrix3d w = hat(omega);
  return Eigen::Matrix3d::Identity() + b * w + c * w * w;
}

Eigen::Matrix3d left_jacobian_inverse(const Eigen::Vector3d& omega) {
  const double theta = omega.norm();
  const auto [a, b, c] = rodrigues(theta);
  const double k = theta < 0.01 ? 1.0 / 12 + theta * theta / 720 : (1 - a / (2 * b)) / (theta * theta);
  const Eigen::Matrix3d w = hat(omega);
  return Eigen::Matrix3d::Identity() - 0.5 * w + k * w * w;
}

double angle(const Eigen::Matrix3d& rotation) { return log(rotation).norm(); }

}  // namespace so3

SE3 SE3::exp(const Vector6d& xi) {
  const Eigen::Vector3d omega = xi.head<3>();
  return {so3::exp(omega), so3::left_jacobian(omega) * xi.tail<3>()};
}

Vector6d SE3::log() const {
  Vector6d xi;
  xi.head<3>() = so3::log(rotation_);
  xi.tail<3>() = so3::left_jacobian_inverse(xi.head<3>()) * translation_;
  return xi;
}

Matrix6d SE3::adjoint() const {
  Matrix6d ad = Matrix6d::Zero();
  ad.topLeftCorner<3, 3>() = rotation_;
  ad.bottomRightCorner<3, 3>() = rotation_;
  ad.bottomLeftCorner<3, 3>() = hat(translation_) * rotation_;
  return ad;
}

RigidTransform to_kernel(const SE3& a_from_b) {
  RigidTransform k{};
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) k.r[3 * row + col] = static_cast<float>(a_from_b.rotation()(row, col));
    k.t[row] = static_cast<float>(a_from_b.translation()[row]);
  }
  return k;
}

}  // namespace plumbline
