// A recording played as its camera gave it: what comes while a frame is worked on is lost.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "plumbline/frame.h"
#include "plumbline/time.h"
#include "reconstruction/frame_source.h"

namespace plumbline::app {

/// Gives each frame of another source no sooner than its stamp says, the first one at once, and drops those that the
/// next one has followed by then. What is dropped depends on the machine and on what else it does.
class RealtimeSource : public FrameSource {
 public:
  /// `speed` 2 plays twice as fast.
  RealtimeSource(std::unique_ptr<FrameSource> frames, double speed);

  SequenceInfo info() const override { return frames_->info(); }
  std::vector<std::string> describe() const override;
  bool has_color() const override { return frames_->has_color(); }
  int total() const override { return frames_->total(); }
  std::optional<Frame> next(const std::function<bool()>& stopping) override;
  ReadTimes read_times() const override { return current_.times; }
  std::optional<OrientationReading> reading() const override { return current_.reading; }
  std::optional<OrientationStreamOptions> orientation() const override { return frames_->orientation(); }
  std::optional<LiveCounts> live() const override { return counts_; }
  void delay(Nanoseconds time) override;
  const Sequence* recording() const override { return frames_->recording(); }
  std::vector<std::string> skipped() const override { return frames_->skipped(); }
  std::vector<std::string> take_messages() override { return frames_->take_messages(); }

 private:
  using Clock = std::chrono::steady_clock;
  struct Item {
    std::optional<Frame> frame;  ///< none after the last
    ReadTimes times;
    std::optional<OrientationReading> reading;
  };

  Item read(const std::function<bool()>& stopping);
  Clock::time_point due(const Frame& frame) const;
  void wait_until(Clock::time_point time, const std::function<bool()>& stopping) const;

  std::unique_ptr<FrameSource> frames_;
  double speed_;
  Nanoseconds first_ = 0;                   ///< stamp of the first frame,
  std::optional<Clock::time_point> start_;  ///< which was given then; none before
  Item current_, following_;
  LiveCounts counts_;
};

}  // namespace plumbline::app
