#include "tracking/solver.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

namespace plumbline {

Solution solve(const Matrix6d& h, const Vector6d& b, double max_condition) {
  Solution solution;
  solution.condition = std::numeric_limits<double>::infinity();
  const double rotation = h.topLeftCorner<3, 3>().trace(), translation = h.bottomRightCorner<3, 3>().trace();
  if (!h.allFinite() || !b.allFinite() || !(rotation > 0) || !(translation > 0)) return solution;

  Vector6d scale = Vector6d::Ones();
  scale.head<3>().setConstant(std::sqrt(translation / rotation));
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(scale.asDiagonal() * h * scale.asDiagonal());
  const Vector6d& values = eigen.eigenvalues();  // ascending
  const Vector6d projected = eigen.eigenvectors().transpose() * scale.cwiseProduct(b);
  Vector6d x = Vector6d::Zero();
  for (int i = 0; i < 6; ++i) {
    if (!(values[i] * max_condition > values[5])) continue;
    x += eigen.eigenvectors().col(i) * (projected[i] / values[i]);
    ++solution.rank;
  }
  solution.step = scale.cwiseProduct(x);
  if (values[0] > 0) solution.condition = values[5] / values[0];
  return solution;
}

}  // namespace plumbline
