#include "eval/similarity.h"

#include <utility>

namespace plumbline::eval {

double similarity_scale(const Trajectory& reference, const Trajectory& estimate, const AssociationOptions& options) {
  const AbsoluteError rigid = absolute_trajectory_error(reference, estimate, options);
  const auto count = static_cast<double>(rigid.pairs.size());
  Eigen::Vector3d mean_target = Eigen::Vector3d::Zero(), mean_source = Eigen::Vector3d::Zero();
  for (const AbsoluteError::Pair& pair : rigid.pairs) {
    mean_target += reference[pair.reference].world_from_camera.translation() / count;
    mean_source += estimate[pair.estimate].world_from_camera.translation() / count;
  }
  double along = 0, spread = 0;
  for (const AbsoluteError::Pair& pair : rigid.pairs) {
    const Eigen::Vector3d target = reference[pair.reference].world_from_camera.translation() - mean_target;
    const Eigen::Vector3d source = estimate[pair.estimate].world_from_camera.translation() - mean_source;
    along += target.dot(rigid.reference_from_estimate.rotation() * source);
    spread += source.squaredNorm();
  }
  return spread > 0 && along > 0 ? along / spread : 1;
}

Trajectory scaled(Trajectory trajectory, double scale) {
  for (StampedPose& pose : trajectory)
    pose.world_from_camera = SE3(pose.world_from_camera.rotation(), scale * pose.world_from_camera.translation());
  return trajectory;
}

std::optional<double> error_if_inverted(const Trajectory& reference, const Trajectory& estimate,
                                        const AssociationOptions& options) {
  constexpr double kMuchBetter = 0.2, kNoError = 1e-3;  // metres
  Trajectory inverted = estimate;
  for (StampedPose& pose : inverted) pose.world_from_camera = pose.world_from_camera.inverse();
  const double as_it_is = absolute_trajectory_error(reference, estimate, options).translation.rmse;
  const double other = absolute_trajectory_error(reference, inverted, options).translation.rmse;
  return as_it_is > kNoError && other < kMuchBetter * as_it_is ? std::optional(other) : std::nullopt;
}

}  // namespace plumbline::eval
