// Where the map is looked at from, and which part of it was made on the way there.
#pragma once

#include <cmath>

#include "plumbline/se3.h"

namespace plumbline {

struct Viewpoint {
  SE3 world_from_camera;
  double travelled = 0;  ///< metres that the map's window had moved since the start, when the camera was there
};

/// Over so many metres the path drifts by less than the truncation, so that parts of the map agree. Beyond, a frame
/// between both would be registered to neither (docs/method.md §6.5).
constexpr double kConsistentOver = 10;

/// Whether parts of the map that were made at these `travelled` may be looked at together.
inline bool are_consistent(double a, double b) { return std::abs(a - b) <= kConsistentOver; }

}  // namespace plumbline
