// Whether the orientation readings turn as the tracked camera does: asked once, as soon as the motion can tell.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "imu/convention_check.h"
#include "imu/orientation_stream.h"
#include "pipeline/pipeline.h"

namespace plumbline::app {

class OrientationCheck {
 public:
  explicit OrientationCheck(const OrientationStream& stream) : stream_(&stream) {}

  /// Takes note of a frame. Returns what the user should know, once, if the readings do not fit as declared.
  std::optional<std::string> observe(const FrameReport& report);

 private:
  struct Tracked {
    Eigen::Matrix3d world_from_camera, earth_from_body;
  };
  const OrientationStream* stream_;
  std::deque<Tracked> recent_;
  std::vector<TurnPair> pairs_;
  bool done_ = false;
};

}  // namespace plumbline::app
