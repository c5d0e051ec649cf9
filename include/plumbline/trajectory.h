// The camera's path.
#pragma once

#include <vector>

#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"

namespace plumbline {

struct StampedPose {
  Nanoseconds time = 0;
  SE3 world_from_camera;
};

/// Ordered by time.
using Trajectory = std::vector<StampedPose>;

}  // namespace plumbline
