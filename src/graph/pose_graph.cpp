#include "graph/pose_graph.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

namespace plumbline {
namespace {

/// A node's parameters are what moves it: (θ, d) with R = exp(θ) R₀ and t = t₀ + d.
using Moved = std::array<double, 6>;

SE3 pose_of(const SE3& start, const double* moved) {
  const Eigen::Map<const Vector6d> x(moved);
  return {so3::exp(Eigen::Vector3d(x.head<3>())) * start.rotation(), start.translation() + x.tail<3>()};
}

/// From derivatives by an increment at the pose to those by the parameters.
Matrix6d by_parameters(const Matrix6d& by_increment, const double* moved) {
  Matrix6d j = by_increment;
  j.leftCols<3>() = by_increment.leftCols<3>() * so3::left_jacobian(Eigen::Map<const Eigen::Vector3d>(moved));
  return j;
}

/// W with WᵀW = Σ⁻¹.
Matrix6d whitening(const Matrix6d& covariance) {
  const Eigen::LLT<Matrix6d> factor(covariance);
  return factor.matrixL().solve(Matrix6d::Identity());
}

using RowMajor6d = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

class MotionCost : public ceres::SizedCostFunction<6, 6, 6> {
 public:
  MotionCost(const PoseConstraint& constraint, const SE3& first, const SE3& second)
      : z_(constraint.first_from_second),
        first_(first),
        second_(second),
        whitening_(whitening(constraint.covariance)) {}

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const SE3 a = pose_of(first_, x[0]), b = pose_of(second_, x[1]);
    Eigen::Map<Vector6d> r(residuals);
    r = whitening_ * constraint_residual(a, b, z_);
    if (jacobians == nullptr) return true;
    const ConstraintJacobians j = constraint_jacobians(a, b, z_);
    write(j.first, x[0], jacobians[0]);
    write(j.second, x[1], jacobians[1]);
    return true;
  }

 private:
  void write(const Matrix6d& by_increment, const double* moved, double* out) const {
    if (out == nullptr) return;
    Eigen::Map<RowMajor6d> j(out);
    j = whitening_ * by_parameters(by_increment, moved);
  }

  SE3 z_, first_, second_;
  Matrix6d whitening_;
};

/// (R u − U) / σ: of unit vectors, so that only the tilt counts.
class UpCost : public ceres::SizedCostFunction<3, 6> {
 public:
  UpCost(const UpConstraint& constraint, const SE3& start) : up_(constraint), start_(start) {}

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const Eigen::Vector3d up = pose_of(start_, x[0]).rotation() * up_.up;
    Eigen::Map<Eigen::Vector3d> r(residuals);
    r = (up - up_.world_up) / up_.sigma;
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    Eigen::Map<Eigen::Matrix<double, 3, 6, Eigen::RowMajor>> j(jacobians[0]);
    j.setZero();
    j.leftCols<3>() = -hat(up) * so3::left_jacobian(Eigen::Map<const Eigen::Vector3d>(x[0])) / up_.sigma;
    return true;
  }

 private:
  UpConstraint up_;
  SE3 start_;
};

ceres::Solver::Options solver_options() {
  ceres::Solver::Options options;
  // One thread, and no BLAS whose sums depend on the number of threads.
  options.num_threads = 1;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  options.max_num_iterations = 100;
  options.function_tolerance = 1e-9;
  options.logging_type = ceres::SILENT;
  return options;
}

}  // namespace

Vector6d constraint_residual(const SE3& world_from_first, const SE3& world_from_second, const SE3& first_from_second) {
  const Eigen::Matrix3d back = world_from_first.rotation().transpose();
  Vector6d r;
  r.head<3>() = so3::log(back * world_from_second.rotation() * first_from_second.rotation().transpose());
  r.tail<3>() =
      back * (world_from_second.translation() - world_from_first.translation()) - first_from_second.translation();
  return r;
}

ConstraintJacobians constraint_jacobians(const SE3& world_from_first, const SE3& world_from_second,
                                         const SE3& first_from_second) {
  const Eigen::Matrix3d back = world_from_first.rotation().transpose();
  const Vector6d r = constraint_residual(world_from_first, world_from_second, first_from_second);
  const Eigen::Vector3d between = world_from_second.translation() - world_from_first.translation();
  const Eigen::Matrix3d turn = so3::left_jacobian_inverse(Eigen::Vector3d(r.head<3>())) * back;
  ConstraintJacobians j{Matrix6d::Zero(), Matrix6d::Zero()};
  j.first.topLeftCorner<3, 3>() = -turn;
  j.first.bottomLeftCorner<3, 3>() = back * hat(between);
  j.first.bottomRightCorner<3, 3>() = -back;
  j.second.topLeftCorner<3, 3>() = turn;
  j.second.bottomRightCorner<3, 3>() = back;
  return j;
}

double squared_error(const PoseConstraint& constraint, const std::vector<SE3>& world_from_node) {
  const Vector6d r = constraint_residual(world_from_node[constraint.first], world_from_node[constraint.second],
                                         constraint.first_from_second);
  return r.dot(constraint.covariance.ldlt().solve(r));
}

std::optional<std::vector<SE3>> optimise(const PoseGraph& graph) {
  std::vector<Moved> moved(graph.world_from_node.size(), Moved{});
  ceres::Problem problem;
  for (const PoseConstraint& c : graph.constraints)
    problem.AddResidualBlock(new MotionCost(c, graph.world_from_node[c.first], graph.world_from_node[c.second]),
                             c.robust > 0 ? new ceres::CauchyLoss(c.robust) : nullptr, moved[c.first].data(),
                             moved[c.second].data());
  for (const UpConstraint& up : graph.ups)
    problem.AddResidualBlock(new UpCost(up, graph.world_from_node[up.node]), nullptr, moved[up.node].data());
  if (moved.empty() || !problem.HasParameterBlock(moved.front().data())) return std::nullopt;
  problem.SetParameterBlockConstant(moved.front().data());
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options(), &problem, &summary);
  std::vector<SE3> poses;
  for (std::size_t i = 0; i < moved.size(); ++i)
    poses.push_back(pose_of(graph.world_from_node[i], moved[i].data()).normalized());
  const bool is_good = summary.IsSolutionUsable() &&
                       std::all_of(poses.begin(), poses.end(), [](const SE3& pose) { return pose.is_finite(); });
  return is_good ? std::optional(poses) : std::nullopt;
}

}  // namespace plumbline
