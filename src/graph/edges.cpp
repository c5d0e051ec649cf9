#include "graph/edges.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "tracking/live_frame.h"
#include "tracking/registration.h"
#include "tracking/starts.h"

namespace plumbline {
namespace {

constexpr int kFarLevels = 2;
constexpr float kDecimationRange = 0.09f;  // metres, as of a frame that is tracked
constexpr int kCompareStride = 4;          // pixels
constexpr std::size_t kKept = 4;           // views with their maps

SE3 halfway(const SE3& a, const SE3& b) {
  const Vector6d d = pose_difference(b, a);
  return SE3(so3::exp(Eigen::Vector3d(0.5 * d.head<3>())) * a.rotation(), a.translation() + 0.5 * d.tail<3>())
      .normalized();
}

}  // namespace

RelativePose inverse(const RelativePose& motion) {
  const Eigen::Matrix3d back = motion.first_from_second.rotation().transpose();
  Matrix6d j = Matrix6d::Zero();
  j.topLeftCorner<3, 3>() = j.bottomRightCorner<3, 3>() = -back;
  j.bottomLeftCorner<3, 3>() = -back * hat(motion.first_from_second.translation());
  return {motion.first_from_second.inverse(), j * motion.covariance * j.transpose()};
}

double normalised_difference(const SE3& a, const SE3& b, const Matrix6d& covariance) {
  const Vector6d d = pose_difference(a, b);
  return d.dot(covariance.ldlt().solve(d)) / 6;
}

ViewMatcher::ViewMatcher(const Parameters& parameters, const Pinhole& camera, const Backend& backend)
    : far_(far_reaching(parameters.tracking, kFarLevels)),
      near_(without_limits(parameters.tracking)),
      level_camera_(camera.level(parameters.tracking.finest_level)),
      backend_(&backend) {
  for (std::size_t i = 0; i < kKept; ++i)
    loaded_.push_back({make_pyramid(camera, static_cast<int>(parameters.tracking.iterations.size()), backend,
                                    parameters.tracking.finest_level),
                       std::nullopt});
  // The pyramids begin at the finest level that is tracked.
  far_.finest_level = near_.finest_level = 0;
}

const DepthPyramid& ViewMatcher::load(const std::vector<PathView>& views, std::size_t view) {
  auto at = std::find_if(loaded_.begin(), loaded_.end(), [&](const Loaded& l) { return l.view == view; });
  if (at == loaded_.end()) {
    at = std::min_element(loaded_.begin(), loaded_.end(),
                          [](const Loaded& a, const Loaded& b) { return a.used < b.used; });
    at->view = view;
    DepthPyramid& levels = at->levels;
    upload(*backend_, views[view].depth, levels.front().depth);
    for (std::size_t i = 1; i < levels.size(); ++i)
      backend_->run(kernels::DecimateDepth{read_only(levels[i - 1].depth), levels[i].depth.view(), kDecimationRange});
    for (DepthLevel& level : levels) estimate_normals(*backend_, level);
  }
  at->used = ++calls_;
  return at->levels;
}

std::optional<RelativePose> ViewMatcher::align(const DepthPyramid& live, const DepthPyramid& model,
                                               const SE3& model_from_live, Reach reach) const {
  RegistrationInput input;
  input.world_from_camera_seed = model_from_live;
  if (reach == Reach::far) {
    const TrackingResult coarse = register_frame(*backend_, live, model, input, far_);
    if (coarse.rank < 6 || !coarse.world_from_camera.is_finite()) return std::nullopt;
    input.world_from_camera_seed = coarse.world_from_camera;
  }
  const TrackingResult fine = register_frame(*backend_, live, model, input, near_);
  if (fine.status == TrackingStatus::lost || fine.pose_covariance.isZero(0)) return std::nullopt;
  return RelativePose{fine.world_from_camera, fine.pose_covariance};
}

std::optional<ViewEdge> ViewMatcher::match(const std::vector<PathView>& views, std::size_t first, std::size_t second,
                                           Reach reach) {
  const DepthPyramid &a = load(views, first), &b = load(views, second);
  const SE3 seed = views[first].world_from_camera.inverse() * views[second].world_from_camera;
  const std::optional<RelativePose> forward = align(b, a, seed, reach);
  if (!forward) return std::nullopt;
  std::optional<RelativePose> backward = align(a, b, seed.inverse(), reach);
  if (!backward) return std::nullopt;
  *backward = inverse(*backward);
  ViewEdge edge;
  edge.first = first;
  edge.second = second;
  edge.apart = pose_difference(forward->first_from_second, backward->first_from_second);
  edge.motion.first_from_second = halfway(forward->first_from_second, backward->first_from_second);
  edge.inconsistency = normalised_difference(forward->first_from_second, backward->first_from_second,
                                             forward->covariance + backward->covariance);
  edge.motion.covariance =
      0.5 * (forward->covariance + backward->covariance) + 0.25 * edge.apart * edge.apart.transpose();
  edge.forward = compare_views(views[second].depth, views[first].depth, level_camera_, edge.motion.first_from_second,
                               kCompareStride);
  edge.backward = compare_views(views[first].depth, views[second].depth, level_camera_,
                                edge.motion.first_from_second.inverse(), kCompareStride);
  return edge;
}

}  // namespace plumbline
