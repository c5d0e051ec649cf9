#include "tracking/priors.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace plumbline {

NormalEquations PriorSum::evaluate(const SE3& world_from_camera, const Association& found) const {
  NormalEquations sum;
  for (const Prior* prior : priors_) {
    const NormalEquations term = prior->evaluate(world_from_camera, found);
    sum.h += term.h;
    sum.b += term.b;
  }
  return sum;
}

double registration_information(const TrackingParameters& parameters, int level_pixels) {
  constexpr double kReferencePixels = 320 * 240;
  const double redundancy = std::max(1.0, parameters.redundancy * level_pixels / kReferencePixels);
  return 1 / (redundancy * parameters.residual_sigma * parameters.residual_sigma);
}

double lambda(LambdaSchedule schedule, double c, double matched_fraction) {
  if (!(matched_fraction > 0)) return 0;
  switch (schedule) {
    case LambdaSchedule::constant:
      return c;
    case LambdaSchedule::inverse_sqrt:
      return c / std::sqrt(matched_fraction);
    case LambdaSchedule::inverse:
      return c / matched_fraction;
    case LambdaSchedule::inverse_square:
      return c / (matched_fraction * matched_fraction);
    case LambdaSchedule::negative_log:
      return -c * std::log(matched_fraction);
  }
  return 0;
}

NormalEquations RotationDamping::evaluate(const SE3& /*world_from_camera*/, const Association& found) const {
  const double fraction = static_cast<double>(found.matched_pixels) / found.level_pixels;
  NormalEquations term;
  term.h.topLeftCorner<3, 3>().diagonal().setConstant(2 * lambda(schedule_, c_, fraction) * found.matched_pixels *
                                                      found.information);
  return term;
}

NormalEquations OrientationAnchor::evaluate(const SE3& world_from_camera, const Association& /*found*/) const {
  const Eigen::Vector3d residual =
      so3::log(earth_from_world_ * world_from_camera.rotation() * earth_from_camera_.transpose());
  // log(exp(E_R_W ω) exp(r)) ≈ r + J_l⁻¹(r) E_R_W ω.
  const Eigen::Matrix3d jacobian = so3::left_jacobian_inverse(residual) * earth_from_world_;
  NormalEquations term;
  term.h.topLeftCorner<3, 3>() = jacobian.transpose() * information_ * jacobian;
  term.b.head<3>() = -jacobian.transpose() * information_ * residual;
  return term;
}

TiltAnchor::TiltAnchor(const Eigen::Matrix3d& earth_from_camera, const Eigen::Matrix3d& earth_from_world,
                       const Eigen::Matrix3d& covariance)
    : up_in_camera_(earth_from_camera.row(2)), earth_from_world_(earth_from_world) {
  information_.topLeftCorner<2, 2>() = covariance.topLeftCorner<2, 2>().inverse();
}

NormalEquations TiltAnchor::evaluate(const SE3& world_from_camera, const Association& /*found*/) const {
  // exp(ω) on the left of the rotation moves u by (E_R_W ω) × u.
  const Eigen::Vector3d up = earth_from_world_ * (world_from_camera.rotation() * up_in_camera_),
                        residual = Eigen::Vector3d::UnitZ().cross(up);
  const Eigen::Matrix3d jacobian = -hat(Eigen::Vector3d::UnitZ()) * hat(up) * earth_from_world_;
  NormalEquations term;
  term.h.topLeftCorner<3, 3>() = jacobian.transpose() * information_ * jacobian;
  term.b.head<3>() = -jacobian.transpose() * information_ * residual;
  return term;
}

Eigen::Matrix3d anchor_covariance(const OrientationParameters& parameters) {
  constexpr double kRadiansPerDegree = std::numbers::pi / 180;
  if (!parameters.covariance.empty())
    return Eigen::Matrix3d::Map(parameters.covariance.data()) * (kRadiansPerDegree * kRadiansPerDegree);
  const double tilt = parameters.tilt_sigma * kRadiansPerDegree, heading = parameters.heading_sigma * kRadiansPerDegree;
  return Eigen::Vector3d(tilt * tilt, tilt * tilt, heading * heading).asDiagonal();
}

NormalEquations TranslationPrior::evaluate(const SE3& world_from_camera, const Association& /*found*/) const {
  // exp(ξ) moves t to t + ω × t + v.
  Eigen::Matrix<double, 3, 6> jacobian;
  jacobian << -hat(world_from_camera.translation()), Eigen::Matrix3d::Identity();
  const Eigen::Vector3d residual = world_from_camera.translation() - expected_;
  return {jacobian.transpose() * information_ * jacobian, -jacobian.transpose() * information_ * residual};
}

}  // namespace plumbline
