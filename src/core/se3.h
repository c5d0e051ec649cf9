// Rotations and rigid motions in double precision.
//
// The perturbation is on the left everywhere: T ← exp(ξ) T with ξ = (ω, v), rotation first (radians, then metres).
// Formulas: Solà, Deray, Atchuthan, "A micro Lie theory for state estimation in robotics", 2018 (arXiv 1812.01537).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/vec3.h"

namespace plumbline {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Skew-symmetric matrix: hat(a) b = a × b.
Eigen::Matrix3d hat(const Eigen::Vector3d& a);

namespace so3 {
/// Rotation vector (radians) to rotation matrix; exact to rounding for every angle, zero included.
Eigen::Matrix3d exp(const Eigen::Vector3d& omega);
/// Rotation matrix to rotation vector with angle in [0, π].
Eigen::Vector3d log(const Eigen::Matrix3d& rotation);
/// Left Jacobian: exp(ω + δ) ≈ exp(J(ω) δ) exp(ω).
Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& omega);
Eigen::Matrix3d left_jacobian_inverse(const Eigen::Vector3d& omega);
/// Angle of the rotation in [0, π], radians.
double angle(const Eigen::Matrix3d& rotation);
}  // namespace so3

/// Rigid motion. A variable of this type is named by its frames: `a_from_b * p_b` is `p_a`.
class SE3 {
 public:
  SE3() = default;
  SE3(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation)
      : rotation_(rotation), translation_(translation) {}
  SE3(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation)
      : SE3(rotation.normalized().toRotationMatrix(), translation) {}

  /// ξ = (ω, v): rotation vector in radians, then the translational part in metres.
  static SE3 exp(const Vector6d& xi);
  Vector6d log() const;

  SE3 inverse() const { return {rotation_.transpose(), -(rotation_.transpose() * translation_)}; }
  /// Ad with T exp(ξ) T⁻¹ = exp(Ad ξ).
  Matrix6d adjoint() const;

  SE3 operator*(const SE3& other) const {
    return {rotation_ * other.rotation_, rotation_ * other.translation_ + translation_};
  }
  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const { return rotation_ * p + translation_; }

  const Eigen::Matrix3d& rotation() const { return rotation_; }
  const Eigen::Vector3d& translation() const { return translation_; }
  Eigen::Quaterniond quaternion() const { return Eigen::Quaterniond(rotation_).normalized(); }
  /// Removes the rounding that products of many rotations collect: the nearest rotation, by its quaternion.
  SE3 normalized() const { return {quaternion(), translation_}; }
  bool is_finite() const { return rotation_.allFinite() && translation_.allFinite(); }

 private:
  Eigen::Matrix3d rotation_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation_ = Eigen::Vector3d::Zero();
};

/// The single-precision form that kernels take.
RigidTransform to_kernel(const SE3& a_from_b);

}  // namespace plumbline
