#include "place/keyframes.h"

#include <algorithm>

namespace plumbline {
namespace {

constexpr double kMetresPerRadian = 1.5;  // the usual distance of a scene: a turn moves what is seen as much
constexpr double kStep = 0.25;            // radians, between keyframes

}  // namespace

double pose_distance(const SE3& a, const SE3& b) {
  return so3::angle(a.rotation().transpose() * b.rotation()) +
         (a.translation() - b.translation()).norm() / kMetresPerRadian;
}

bool Keyframes::offer(const PlaceView& view, const Viewpoint& from) {
  const bool is_near = std::any_of(keyframes_.begin(), keyframes_.end(), [&](const Keyframe& keyframe) {
    return are_consistent(keyframe.from.travelled, from.travelled) &&
           pose_distance(keyframe.from.world_from_camera, from.world_from_camera) < kStep;
  });
  if (is_near) return false;
  Keyframe keyframe{from, view.earth_from_camera, encode(view.live), {}};
  for (std::size_t level = view.live.size() - static_cast<std::size_t>(levels_); level < view.live.size(); ++level)
    keyframe.depth.push_back(download(*backend_, view.live[level].depth));
  keyframes_.push_back(std::move(keyframe));
  return true;
}

FernCode Keyframes::encode(const DepthPyramid& live) const {
  const DepthLevel& coarsest = live.back();
  return ferns_.encode(make_thumbnail(download(*backend_, coarsest.depth),
                                      {download(*backend_, coarsest.normal_x), download(*backend_, coarsest.normal_y),
                                       download(*backend_, coarsest.normal_z)}));
}

}  // namespace plumbline
