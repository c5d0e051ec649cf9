// How well a 6×6 system is posed; kernels/normal_equations.h solves it.
#pragma once

#include "kernels/normal_equations.h"
#include "plumbline/se3.h"

namespace plumbline {

/// Largest over smallest eigenvalue, the rotation scaled as for the solution; infinite when singular.
double condition(const Matrix6d& h);

}  // namespace plumbline
