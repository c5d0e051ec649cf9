// What is known beside the depth image, as 6×6 terms: the second and third of H = H_icp/κσ² + H_orientation +
// H_translation. Plain values, which a device takes as they are.
#pragma once

#include "kernels/normal_equations.h"
#include "plumbline/parameters.h"
#include "plumbline/se3.h"

namespace plumbline::kernels {

/// What an iteration's association found.
struct Association {
  int matched_pixels = 0, level_pixels = 1;
  double information = 1;  ///< what a pixel's squared residual weighs, see registration_information
};

/// λ of the matched fraction ν in (0, 1] (METHOD.md §3); 0 for nothing matched.
PL_SHARED double lambda(LambdaSchedule schedule, double c, double matched_fraction) {
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

/// The published regulariser (METHOD.md §3): 2λn damps the rotation of each step, n the matched pixels;
/// on the scale of the registration's sums.
struct RotationDamping {
  LambdaSchedule schedule = LambdaSchedule::constant;
  double c = 0;

  PL_SHARED NormalEquations evaluate(const Association& found) const {
    const double fraction = static_cast<double>(found.matched_pixels) / found.level_pixels;
    NormalEquations term;
    term.h.topLeftCorner<3, 3>().diagonal().setConstant(2 * lambda(schedule, c, fraction) * found.matched_pixels *
                                                        found.information);
    return term;
  }
};

/// Of a residual r in earth axes with r(exp(ω) R) ≈ r + J ω.
PL_SHARED NormalEquations rotation_term(const Eigen::Vector3d& residual, const Eigen::Matrix3d& jacobian,
                                        const Eigen::Matrix3d& information) {
  NormalEquations term;
  term.h.topLeftCorner<3, 3>() = jacobian.transpose() * information * jacobian;
  term.b.head<3>() = -jacobian.transpose() * information * residual;
  return term;
}

/// The sensor's reading as a measurement (METHOD.md §6.4): residual log(R R_absᵀ) in earth axes with the sensor's own
/// covariance. However many steps are taken, the rotation is judged against the reading.
struct OrientationAnchor {
  Eigen::Matrix3d earth_from_camera, earth_from_world;
  Eigen::Matrix3d information;  ///< inverse of the covariance: 1/radians², earth axes

  PL_SHARED NormalEquations evaluate(const SE3& world_from_camera) const {
    const Eigen::Matrix3d apart = earth_from_world * world_from_camera.rotation() * earth_from_camera.transpose();
    const Eigen::Vector3d residual = so3::log(apart);
    // log(exp(E_R_W ω) exp(r)) ≈ r + J_l⁻¹(r) E_R_W ω.
    return rotation_term(residual, so3::left_jacobian_inverse(residual) * earth_from_world, information);
  }
};

/// The tilt of a sensor without heading: residual z × u, u being where the estimate has what the sensor calls up. In
/// earth axes, radians for small tilts; about the vertical nothing is held (METHOD.md §6.4 with an infinite heading
/// variance). What heading the reading has does not matter.
struct TiltAnchor {
  Eigen::Vector3d up_in_camera;
  Eigen::Matrix3d earth_from_world;
  Eigen::Matrix3d information;  ///< 1/radians², earth axes; of the horizontal part alone

  PL_SHARED NormalEquations evaluate(const SE3& world_from_camera) const {
    // exp(ω) on the left of the rotation moves u by (E_R_W ω) × u.
    const Eigen::Vector3d up = earth_from_world * (world_from_camera.rotation() * up_in_camera),
                          vertical = Eigen::Vector3d::UnitZ(), residual = vertical.cross(up);
    return rotation_term(residual, -hat(vertical) * hat(up) * earth_from_world, information);
  }
};

/// The camera is about where it is expected (METHOD.md §6.2): residual t − t_expected.
struct TranslationPrior {
  Eigen::Vector3d expected;
  Eigen::Matrix3d information;  ///< 1/metres²

  PL_SHARED NormalEquations evaluate(const SE3& world_from_camera) const {
    // exp(ξ) moves t to t + ω × t + v.
    Eigen::Matrix<double, 3, 6> jacobian;
    jacobian.leftCols<3>() = -hat(world_from_camera.translation());
    jacobian.rightCols<3>().setIdentity();
    const Eigen::Vector3d residual = world_from_camera.translation() - expected;
    NormalEquations term;
    term.h = jacobian.transpose() * information * jacobian;
    term.b = -jacobian.transpose() * information * residual;
    return term;
  }
};

enum class OrientationPrior { none, damping, anchor, tilt };

/// All that is known beside one frame's depth.
struct Priors {
  OrientationPrior orientation = OrientationPrior::none;
  RotationDamping damping;
  OrientationAnchor anchor;
  TiltAnchor tilt;
  bool has_position = false;
  TranslationPrior position;

  PL_SHARED bool empty() const { return orientation == OrientationPrior::none && !has_position; }

  /// In left increments of world_from_camera, at an estimate.
  PL_SHARED NormalEquations evaluate(const SE3& world_from_camera, const Association& found) const {
    NormalEquations sum;
    if (orientation == OrientationPrior::damping) sum = damping.evaluate(found);
    if (orientation == OrientationPrior::anchor) sum = anchor.evaluate(world_from_camera);
    if (orientation == OrientationPrior::tilt) sum = tilt.evaluate(world_from_camera);
    if (has_position) {
      const NormalEquations term = position.evaluate(world_from_camera);
      sum.h += term.h;
      sum.b += term.b;
    }
    return sum;
  }
};

}  // namespace plumbline::kernels
