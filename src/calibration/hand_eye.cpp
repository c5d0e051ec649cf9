#include "calibration/hand_eye.h"

#include <Eigen/Dense>
#include <cmath>
#include <optional>

namespace plumbline {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// 2 sin(θ/2) n of a rotation vector θ n.
Vector3d half_sine(const Vector3d& turn) {
  const double angle = turn.norm();
  return angle < 1e-9 ? turn : Vector3d(2 * std::sin(angle / 2) / angle * turn);
}

/// tan(θ/2) n of M, the camera's axes turned by `renamed_from_camera` before. Tsai and Lenz (12): with P of both sides,
/// skew(P_b + P_a) x = P_a − P_b for x = tan(θ/2) n of the rotation that takes P_a to P_b.
Vector3d half_tangent(const Turns& turns, const Matrix3d& renamed_from_camera) {
  Matrix3d normal = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (std::size_t i = 0; i < turns.camera.size(); ++i) {
    const Vector3d a = renamed_from_camera * half_sine(turns.camera[i]), b = half_sine(turns.body[i]);
    const Matrix3d row = hat(b + a);
    normal += row.transpose() * row;
    right += row.transpose() * (a - b);
  }
  return normal.completeOrthogonalDecomposition().solve(right);
}

}  // namespace

double turn_residual(const Turns& turns, const Matrix3d& body_from_camera) {
  double sum = 0;
  for (std::size_t i = 0; i < turns.camera.size(); ++i) {
    const Vector3d predicted = body_from_camera.transpose() * turns.body[i];
    const double error = so3::angle(so3::exp(turns.camera[i]).transpose() * so3::exp(predicted));
    sum += error * error;
  }
  return turns.camera.empty() ? 0 : std::sqrt(sum / static_cast<double>(turns.camera.size()));
}

Matrix3d nearest_rotation(const Matrix3d& sum, bool mirrored) {
  const Eigen::JacobiSVD<Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Matrix3d& u = svd.matrixU();
  const Matrix3d& v = svd.matrixV();
  const double handed = (u * v.transpose()).determinant() < 0 ? -1 : 1;
  return u * Vector3d(1, 1, mirrored ? -handed : handed).asDiagonal() * v.transpose();
}

MountingFit fit_mounting(const Turns& turns) {
  Matrix3d sum = Matrix3d::Zero();
  for (std::size_t i = 0; i < turns.camera.size(); ++i) sum += turns.body[i] * turns.camera[i].transpose();
  return {nearest_rotation(sum), nearest_rotation(sum, true)};
}

Matrix3d tsai_lenz(const Turns& turns) {
  // Of the four, one leaves at most 120°: the largest component of a unit quaternion is at least 1/2.
  Matrix3d best = Matrix3d::Identity();
  std::optional<double> best_residual;
  for (const Vector3d& signs : {Vector3d(1, 1, 1), Vector3d(1, -1, -1), Vector3d(-1, 1, -1), Vector3d(-1, -1, 1)}) {
    const Matrix3d renamed_from_camera = signs.asDiagonal();
    const Vector3d x = half_tangent(turns, renamed_from_camera);
    const double size = x.norm();
    const Vector3d rotation = size > 0 ? Vector3d(2 * std::atan(size) / size * x) : Vector3d::Zero();
    const Matrix3d mounting = so3::exp(rotation) * renamed_from_camera;
    const double residual = turn_residual(turns, mounting);
    if (best_residual && residual >= *best_residual) continue;
    best = mounting;
    best_residual = residual;
  }
  return best;
}

}  // namespace plumbline
