// Whether a frame follows the ones before it, or there was an interruption in which the camera may have gone anywhere.
#pragma once

#include <deque>
#include <optional>

#include "plumbline/time.h"

namespace plumbline {

/// How far apart the frames of a recording usually are: every n-th frame of a slow one is no interruption.
class FrameIntervals {
 public:
  /// Every frame, whatever becomes of it.
  void observe(Nanoseconds time);

  /// Whether nothing links a frame to the one that was accepted at `previous`: it is more than `max_gap` seconds later,
  /// and later than frames usually are, as after a single lost frame of a slow recording. A clock that went back is an
  /// interruption of so long.
  bool is_interrupted(Nanoseconds previous, Nanoseconds time, double max_gap) const;

 private:
  std::deque<double> seconds_;  ///< between the frames of late
  std::optional<Nanoseconds> previous_;
};

}  // namespace plumbline
