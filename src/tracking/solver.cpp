#include "tracking/solver.h"
#include "plumbline/se3.h"

#include <Eigen/Eigenvalues>
#include <limits>

namespace plumbline {

double condition(const Matrix6d& h) {
  const double scale = kernels::rotation_scale(h);
  if (scale == 0) return std::numeric_limits<double>::infinity();
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(kernels::scaled(h, scale), Eigen::EigenvaluesOnly);
  const Vector6d& values = eigen.eigenvalues();  // ascending
  return values[0] > 0 ? values[5] / values[0] : std::numeric_limits<double>::infinity();
}

}  // namespace plumbline
