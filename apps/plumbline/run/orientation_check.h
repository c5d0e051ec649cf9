// Whether the orientation readings turn as the tracked camera does: asked once, as soon as the motion can tell.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "plumbline/pipeline.h"
#include "sensor/convention_check.h"
#include "sensor/orientation_stream.h"

namespace plumbline::app {

class OrientationCheck {
 public:
  /// How the readings were declared.
  explicit OrientationCheck(const OrientationStreamOptions& declared) : declared_(declared) {}

  /// Takes note of a frame and its reading. Returns what the user should know, once, if the readings do not fit as
  /// declared.
  std::optional<std::string> observe(const FrameReport& report, const OrientationReading& reading);

 private:
  struct Tracked {
    Eigen::Matrix3d world_from_camera, earth_from_body;
  };
  OrientationStreamOptions declared_;
  std::deque<Tracked> recent_;
  std::vector<TurnPair> pairs_;
  bool done_ = false;
};

}  // namespace plumbline::app
