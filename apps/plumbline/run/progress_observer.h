// How far a run is, on the terminal, and when the camera was lost and found again.
#pragma once

#include <string>

#include "cli/progress.h"
#include "reconstruction/frame_loop.h"

namespace plumbline::app {

class ProgressObserver : public FrameObserver {
 public:
  /// `total`: frames to come; negative if nobody knows. `quiet`: draws nothing.
  ProgressObserver(int total, bool quiet) : progress_(total, quiet) {}

  void observe(const ProcessedFrame& processed) override;
  /// The frames come again, from the first.
  void begin() { frames_ = lost_ = 0; }
  /// A line that stays above the bar.
  void note(const std::string& line) { progress_.note(line); }
  /// Since it was made.
  double seconds() const { return progress_.seconds(); }

 private:
  Progress progress_;
  int frames_ = 0, lost_ = 0;
  bool was_lost_ = false;
};

}  // namespace plumbline::app
