// The 6×6 normal equations of one iteration, solved with rank and condition.
#pragma once

#include "core/se3.h"

namespace plumbline {

struct Solution {
  Vector6d step = Vector6d::Zero();  ///< (ω, v): radians, metres
  int rank = 0;                      ///< directions that the equations hold
  double condition = 0;              ///< largest over smallest eigenvalue after scaling; infinite when singular
};

/// Solves H x = b for a symmetric positive semi-definite H by its eigenvalues. The rotation's rows are first scaled so
/// that both blocks have the same trace, which makes rank and condition independent of the unit of length. Directions
/// whose eigenvalue is below 1/`max_condition` of the largest are left out of the step and of the rank.
Solution solve(const Matrix6d& h, const Vector6d& b, double max_condition);

}  // namespace plumbline
