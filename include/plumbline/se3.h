// Rotations and rigid motions in double precision.
//
// The perturbation is on the left everywhere: T ← exp(ξ) T with ξ = (ω, v), rotation first (radians, then metres).
// Formulas: Solà, Deray, Atchuthan, "A micro Lie theory for state estimation in robotics", 2018 (arXiv 1812.01537).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

#include "plumbline/vec3.h"

namespace plumbline {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Skew-symmetric matrix: hat(a) b = a × b.
PL_SHARED Eigen::Matrix3d hat(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

namespace so3 {
namespace detail {

constexpr double kSmallAngle = 1e-4;  // below it the series' next term is under 1e-17

/// The three coefficients of Rodrigues' formula and its integral: sin θ/θ, (1−cos θ)/θ², (θ−sin θ)/θ³.
struct Rodrigues {
  double a, b, c;
};

PL_SHARED Rodrigues rodrigues(double theta) {
  const double t2 = theta * theta;
  if (theta < kSmallAngle) return {1 - t2 / 6, 0.5 - t2 / 24, 1.0 / 6 - t2 / 120};
  const double half = std::sin(theta / 2) / theta;  // 1 − cos θ = 2 sin²(θ/2): no cancellation
  return {std::sin(theta) / theta, 2 * half * half,
          theta < 0.05 ? 1.0 / 6 - t2 / 120 + t2 * t2 / 5040 - t2 * t2 * t2 / 362880
                       : (theta - std::sin(theta)) / (t2 * theta)};
}

}  // namespace detail

/// Rotation vector (radians) to rotation matrix; exact to rounding for every angle, zero included.
PL_SHARED Eigen::Matrix3d exp(const Eigen::Vector3d& omega) {
  const detail::Rodrigues k = detail::rodrigues(omega.norm());
  const Eigen::Matrix3d w = hat(omega);
  return Eigen::Matrix3d::Identity() + k.a * w + k.b * w * w;
}

/// Rotation matrix to rotation vector with angle in [0, π]. By the quaternion: well conditioned at every angle, π
/// included.
PL_SHARED Eigen::Vector3d log(const Eigen::Matrix3d& rotation) {
  Eigen::Quaterniond q(rotation);
  q.normalize();
  if (q.w() < 0) q.coeffs() *= -1;
  const double s = q.vec().norm();
  if (s < detail::kSmallAngle) return q.vec() * (2 / q.w() * (1 - s * s / (3 * q.w() * q.w())));
  return q.vec() * (2 * std::atan2(s, q.w()) / s);
}

/// Left Jacobian: exp(ω + δ) ≈ exp(J(ω) δ) exp(ω).
PL_SHARED Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& omega) {
  const detail::Rodrigues k = detail::rodrigues(omega.norm());
  const Eigen::Matrix3d w = hat(omega);
  return Eigen::Matrix3d::Identity() + k.b * w + k.c * w * w;
}

PL_SHARED Eigen::Matrix3d left_jacobian_inverse(const Eigen::Vector3d& omega) {
  const double theta = omega.norm();
  const detail::Rodrigues r = detail::rodrigues(theta);
  const double k = theta < 0.01 ? 1.0 / 12 + theta * theta / 720 : (1 - r.a / (2 * r.b)) / (theta * theta);
  const Eigen::Matrix3d w = hat(omega);
  return Eigen::Matrix3d::Identity() - 0.5 * w + k * w * w;
}

/// Angle of the rotation in [0, π], radians.
PL_SHARED double angle(const Eigen::Matrix3d& rotation) { return log(rotation).norm(); }

}  // namespace so3

/// Rigid motion. A variable of this type is named by its frames: `a_from_b * p_b` is `p_a`.
class SE3 {
 public:
  SE3() = default;
  PL_SHARED SE3(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation)
      : rotation_(rotation), translation_(translation) {}
  PL_SHARED SE3(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation)
      : SE3(rotation.normalized().toRotationMatrix(), translation) {}

  /// ξ = (ω, v): rotation vector in radians, then the translational part in metres.
  PL_SHARED static SE3 exp(const Vector6d& xi) {
    const Eigen::Vector3d omega = xi.head<3>();
    return {so3::exp(omega), so3::left_jacobian(omega) * xi.tail<3>()};
  }
  Vector6d log() const {
    Vector6d xi;
    xi.head<3>() = so3::log(rotation_);
    xi.tail<3>() = so3::left_jacobian_inverse(xi.head<3>()) * translation_;
    return xi;
  }

  PL_SHARED SE3 inverse() const { return {rotation_.transpose(), -(rotation_.transpose() * translation_)}; }
  /// Ad with T exp(ξ) T⁻¹ = exp(Ad ξ).
  PL_SHARED Matrix6d adjoint() const {
    Matrix6d ad = Matrix6d::Zero();
    ad.topLeftCorner<3, 3>() = rotation_;
    ad.bottomRightCorner<3, 3>() = rotation_;
    ad.bottomLeftCorner<3, 3>() = hat(translation_) * rotation_;
    return ad;
  }

  PL_SHARED SE3 operator*(const SE3& other) const {
    return {rotation_ * other.rotation_, rotation_ * other.translation_ + translation_};
  }
  PL_SHARED Eigen::Vector3d operator*(const Eigen::Vector3d& p) const { return rotation_ * p + translation_; }

  PL_SHARED const Eigen::Matrix3d& rotation() const { return rotation_; }
  PL_SHARED const Eigen::Vector3d& translation() const { return translation_; }
  PL_SHARED Eigen::Quaterniond quaternion() const { return Eigen::Quaterniond(rotation_).normalized(); }
  /// Removes the rounding that products of many rotations collect: the nearest rotation, by its quaternion.
  PL_SHARED SE3 normalized() const { return {quaternion(), translation_}; }
  bool is_finite() const { return rotation_.allFinite() && translation_.allFinite(); }

 private:
  Eigen::Matrix3d rotation_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation_ = Eigen::Vector3d::Zero();
};

/// The single-precision form that kernels take.
PL_SHARED RigidTransform to_kernel(const SE3& a_from_b) {
  RigidTransform k{};
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) k.r[3 * row + col] = static_cast<float>(a_from_b.rotation()(row, col));
    k.t[row] = static_cast<float>(a_from_b.translation()[row]);
  }
  return k;
}

/// From pose b to pose a, rotation and translation apart: (log(R_a R_bᵀ), t_a − t_b), radians and metres.
PL_SHARED Vector6d pose_difference(const SE3& a, const SE3& b) {
  Vector6d difference;
  difference.head<3>() = so3::log(Eigen::Matrix3d(a.rotation() * b.rotation().transpose()));
  difference.tail<3>() = a.translation() - b.translation();
  return difference;
}

}  // namespace plumbline
