// A graph of poses that are tied by what is known of the motions between them, and the poses that fit all of it best.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "plumbline/se3.h"

namespace plumbline {

/// second = first · first_from_second, with a covariance of (θ, t) as RelativePose has it.
struct PoseConstraint {
  std::size_t first = 0, second = 0;
  SE3 first_from_second;
  Matrix6d covariance = Matrix6d::Identity();
  double robust = 0;  ///< beyond so many standard deviations (of the whole residual) it counts ever less; 0: never
};

/// Where up is by a sensor, in the node's axes, beside up in the world.
struct UpConstraint {
  std::size_t node = 0;
  Eigen::Vector3d up, world_up;  ///< unit vectors
  double sigma = 1;              ///< radians
};

struct PoseGraph {
  std::vector<SE3> world_from_node;  ///< where they seem to be
  std::vector<PoseConstraint> constraints;
  std::vector<UpConstraint> ups;
};

/// Of (log(R_iᵀ R_j Zᵣᵀ), R_iᵀ (t_j − t_i) − Z_t): docs/method.md §12.
Vector6d constraint_residual(const SE3& world_from_first, const SE3& world_from_second, const SE3& first_from_second);

/// rᵀ Σ⁻¹ r of a constraint at these poses.
double squared_error(const PoseConstraint& constraint, const std::vector<SE3>& world_from_node);

/// The poses that minimise the sum of all; the first stays where it is. The same bits on every run. Nothing if it does
/// not converge to finite poses.
std::optional<std::vector<SE3>> optimise(const PoseGraph& graph);

/// The derivatives of the residual, for its test: by (θ, t) of the first and of the second pose, world axes, θ from the
/// left.
struct ConstraintJacobians {
  Matrix6d first, second;
};
ConstraintJacobians constraint_jacobians(const SE3& world_from_first, const SE3& world_from_second,
                                         const SE3& first_from_second);

}  // namespace plumbline
