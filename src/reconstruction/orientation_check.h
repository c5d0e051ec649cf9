// Whether the orientation readings turn as the tracked camera does: asked once, as soon as the motion can tell.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "calibration/convention_check.h"
#include "plumbline/orientation_stream.h"
#include "plumbline/pipeline.h"
#include "reconstruction/frame_loop.h"

namespace plumbline {

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

/// Tells the user of readings that do not fit as declared, and of a sensor that is distrusted or trusted again.
class OrientationObserver : public FrameObserver {
 public:
  /// `declared`: how the readings were declared; none without a sensor.
  OrientationObserver(const std::optional<OrientationStreamOptions>& declared, Note note);

  void observe(const ProcessedFrame& processed) override;

  /// That the readings do not fit as declared, or come from a clock that seems to be far off; empty if neither.
  std::string message() const;

 private:
  std::optional<OrientationCheck> check_;
  std::optional<OrientationUse> previous_;
  std::string message_;
  double lateness_ = 0;  ///< seconds
  Note note_;
};

}  // namespace plumbline
