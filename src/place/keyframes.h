// What is remembered of the places that were mapped: views, each with its pose, a code to find it by, and a coarse
// depth image to register to.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "backend/maps.h"
#include "core/viewpoint.h"
#include "place/ferns.h"
#include "plumbline/image.h"
#include "plumbline/se3.h"

namespace plumbline {

/// How far apart two camera poses are, in radians: 1.5 m of path count as one.
double pose_distance(const SE3& a, const SE3& b);

struct Keyframe {
  Viewpoint from;
  std::optional<Eigen::Matrix3d> earth_from_camera;  ///< a sensor's reading that was trusted, if there was one
  FernCode code;
  std::vector<Image<float>> depth;  ///< metres, level by level, finest first
};

/// A frame that looks for its place, or may become a keyframe.
struct PlaceView {
  const DepthPyramid& live;                          ///< with normals at the levels that are tracked
  std::optional<Eigen::Matrix3d> earth_from_camera;  ///< a reading that is trusted, if there is one
};

/// All keyframes of one map. No two of consistent parts of it are nearer than a step, so that their number follows from
/// what was seen, not from how long it was looked at.
class Keyframes {
 public:
  /// A keyframe keeps the coarsest `levels` levels of a pyramid.
  Keyframes(int levels, const Backend& backend) : levels_(levels), backend_(&backend) {}

  /// Keeps the view if none is near its pose; whether it did.
  bool offer(const PlaceView& view, const Viewpoint& from);

  FernCode encode(const DepthPyramid& live) const;
  /// The `count` keyframes that look most like it, the likest first; those that `is_possible` denies left out.
  template <class IsPossible>
  std::vector<const Keyframe*> nearest(const FernCode& code, std::size_t count, const IsPossible& is_possible) const;

  const std::vector<Keyframe>& all() const { return keyframes_; }

 private:
  int levels_;
  const Backend* backend_;
  Ferns ferns_;
  std::vector<Keyframe> keyframes_;
};

template <class IsPossible>
std::vector<const Keyframe*> Keyframes::nearest(const FernCode& code, std::size_t count,
                                                const IsPossible& is_possible) const {
  struct Rank {
    double dissimilarity;
    const Keyframe* keyframe;
  };
  std::vector<Rank> ranks;
  for (const Keyframe& keyframe : keyframes_)
    if (is_possible(keyframe)) ranks.push_back({dissimilarity(code, keyframe.code), &keyframe});
  std::stable_sort(ranks.begin(), ranks.end(),
                   [](const Rank& a, const Rank& b) { return a.dissimilarity < b.dissimilarity; });
  ranks.resize(std::min(ranks.size(), count));
  std::vector<const Keyframe*> keyframes;
  for (const Rank& rank : ranks) keyframes.push_back(rank.keyframe);
  return keyframes;
}

}  // namespace plumbline
