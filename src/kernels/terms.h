// What is known beside the depth image, as 6×6 terms of H = H_icp/κσ² + Σ H_term: each a struct whose `evaluate` gives
// its normal equations at an estimate. Plain values, which a device takes as they are.
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

/// Where the terms are evaluated.
struct Estimate {
  SE3 world_from_camera;
  Association found = {};
};

/// λ of the matched fraction ν in (0, 1] (docs/method.md §3); 0 for nothing matched.
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

/// The published regulariser (docs/method.md §3): 2λn damps the rotation of each step, n the matched pixels;
/// on the scale of the registration's sums.
struct RotationDamping {
  LambdaSchedule schedule = LambdaSchedule::constant;
  double c = 0;

  PL_SHARED NormalEquations evaluate(const Estimate& at) const {
    const Association& found = at.found;
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

/// The sensor's reading as a measurement (docs/method.md §6.4): residual log(R R_absᵀ) in earth axes with the sensor's
/// own covariance. However many steps are taken, the rotation is judged against the reading.
struct OrientationAnchor {
  Eigen::Matrix3d earth_from_camera, earth_from_world;
  Eigen::Matrix3d information;  ///< inverse of the covariance: 1/radians², earth axes

  PL_SHARED NormalEquations evaluate(const Estimate& at) const {
    const SE3& world_from_camera = at.world_from_camera;
    const Eigen::Matrix3d apart = earth_from_world * world_from_camera.rotation() * earth_from_camera.transpose();
    const Eigen::Vector3d residual = so3::log(apart);
    // log(exp(E_R_W ω) exp(r)) ≈ r + J_l⁻¹(r) E_R_W ω.
    return rotation_term(residual, so3::left_jacobian_inverse(residual) * earth_from_world, information);
  }
};

/// The tilt of a sensor without heading: residual z × u, u being where the estimate has what the sensor calls up. In
/// earth axes, radians for small tilts; about the vertical nothing is held (docs/method.md §6.4 with an infinite
/// heading variance). What heading the reading has does not matter.
struct TiltAnchor {
  Eigen::Vector3d up_in_camera;
  Eigen::Matrix3d earth_from_world;
  Eigen::Matrix3d information;  ///< 1/radians², earth axes; of the horizontal part alone

  PL_SHARED NormalEquations evaluate(const Estimate& at) const {
    const SE3& world_from_camera = at.world_from_camera;
    // exp(ω) on the left of the rotation moves u by (E_R_W ω) × u.
    const Eigen::Vector3d up = earth_from_world * (world_from_camera.rotation() * up_in_camera),
                          vertical = Eigen::Vector3d::UnitZ(), residual = vertical.cross(up);
    return rotation_term(residual, -hat(vertical) * hat(up) * earth_from_world, information);
  }
};

/// The camera is about where it is expected (docs/method.md §6.2): residual t − t_expected.
struct TranslationPrior {
  Eigen::Vector3d expected;
  Eigen::Matrix3d information;  ///< 1/metres²

  PL_SHARED NormalEquations evaluate(const Estimate& at) const {
    const SE3& world_from_camera = at.world_from_camera;
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

/// A Gaussian prediction of the whole pose, as a filter predicts it (docs/method.md §8): residual
/// (log(R R̂ᵀ), t − t̂) in the world's axes.
struct PosePrior {
  SE3 expected;          ///< world_from_camera
  Matrix6d information;  ///< inverse of the covariance: 1/radians², 1/metres²

  PL_SHARED NormalEquations evaluate(const Estimate& at) const {
    const SE3& pose = at.world_from_camera;
    const Vector6d residual = pose_difference(pose, expected);
    // exp(ξ) on the left: log(exp(ω) exp(r)) ≈ r + J_l⁻¹(r) ω, and t moves to t + ω × t + v.
    Matrix6d jacobian = Matrix6d::Zero();
    jacobian.topLeftCorner<3, 3>() = so3::left_jacobian_inverse(residual.head<3>());
    jacobian.bottomLeftCorner<3, 3>() = -hat(pose.translation());
    jacobian.bottomRightCorner<3, 3>().setIdentity();
    NormalEquations term;
    term.h = jacobian.transpose() * information * jacobian;
    term.b = -jacobian.transpose() * information * residual;
    return term;
  }
};

/// Where a list keeps the term of one kind.
template <class Term>
struct TermSlot {
  Term term;
  bool is_set = false;

  PL_SHARED void add(const Estimate& at, NormalEquations* sum) const {
    if (!is_set) return;
    const NormalEquations equations = term.evaluate(at);
    sum->h += equations.h;
    sum->b += equations.b;
  }
};

/// The terms of one frame's solve, at most one of each kind, summed in the order of the kinds whatever the order they
/// were set in: the same result to the bit. A plain value without pointers, which a device takes as it is.
template <class... Kinds>
class TermList : TermSlot<Kinds>... {
 public:
  template <class Term>
  void set(const Term& term) {
    TermSlot<Term>& slot = *this;
    slot.term = term;
    slot.is_set = true;
  }

  /// Null if there is none of the kind.
  template <class Term>
  const Term* find() const {
    const TermSlot<Term>& slot = *this;
    return slot.is_set ? &slot.term : nullptr;
  }

  PL_SHARED bool empty() const { return !(TermSlot<Kinds>::is_set || ...); }

  /// In left increments of world_from_camera.
  PL_SHARED NormalEquations evaluate(const Estimate& at) const {
    NormalEquations sum;
    (TermSlot<Kinds>::add(at, &sum), ...);
    return sum;
  }
};

/// What may stand beside the images. A new term is a struct with `evaluate`, named here.
using Terms = TermList<RotationDamping, OrientationAnchor, TiltAnchor, TranslationPrior, PosePrior>;

}  // namespace plumbline::kernels
