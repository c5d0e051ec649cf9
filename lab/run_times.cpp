#include "lab/run_times.h"

#include <chrono>
#include <cstdlib>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "backend/backend.h"
#include "core/median.h"
#include "plumbline/error.h"
#include "plumbline/time.h"
#include "reconstruction/frame_loop.h"
#include "reconstruction/frame_source.h"

namespace plumbline::app {
namespace {

/// Frames held in memory, first to final and back, with stamps that go on.
class ToAndFroSource : public FrameSource {
 public:
  explicit ToAndFroSource(const StageFrames& frames) : camera_(frames.camera), frames_(frames.frames) {}

  SequenceInfo info() const override {
    SequenceInfo info;
    info.camera = camera_;
    return info;
  }
  std::vector<std::string> describe() const override { return {}; }
  bool has_color() const override { return false; }
  int total() const override { return -1; }
  std::optional<Frame> next(const std::function<bool()>& stopping) override {
    if (stopping()) return std::nullopt;
    const std::size_t intervals = frames_.size() - 1, step = count_ % (2 * intervals);
    const std::size_t at = step <= intervals ? step : 2 * intervals - step;
    if (count_++ > 0) time_ += std::abs(frames_[at].time - frames_[previous_].time);
    previous_ = at;
    Frame frame = frames_[at];
    frame.index = static_cast<int>(count_) - 1;
    frame.time = time_;
    return frame;
  }
  ReadTimes read_times() const override { return {}; }
  std::optional<OrientationReading> reading() const override { return std::nullopt; }
  std::optional<OrientationStreamOptions> orientation() const override { return std::nullopt; }

 private:
  Pinhole camera_;
  const std::vector<Frame>& frames_;
  std::size_t count_ = 0, previous_ = 0;
  Nanoseconds time_ = 0;
};

class StageRecord : public FrameObserver {
 public:
  void observe(const ProcessedFrame& processed) override {
    ++frames;
    if (processed.report.tracking.status == TrackingStatus::tracked) tracked.push_back(processed.report.milliseconds);
  }
  double median_of(double StageTimes::*stage) const {
    std::vector<double> values;
    for (const StageTimes& times : tracked) values.push_back(times.*stage);
    return median(std::move(values));
  }

  std::size_t frames = 0;
  std::vector<StageTimes> tracked;
};

}  // namespace

StageTimes run_stage_times(const StageFrames& frames, const Parameters& parameters, const std::string& backend,
                           int threads, double seconds) {
  if (frames.frames.size() < 2)
    throw Error("there are too few frames to time a run", "bench", "Give a sequence of two frames or more.");
  const std::shared_ptr<Backend> device = make_backend(backend, threads);
  Pipeline pipeline(parameters, frames.camera, *device);
  ToAndFroSource source(frames);
  StageRecord record;
  using Clock = std::chrono::steady_clock;
  const Clock::time_point end =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  run_frames(
      source, pipeline, {&record}, [&] { return record.frames >= frames.frames.size() && Clock::now() >= end; },
      [](const std::string&) {});
  if (record.tracked.empty())
    throw Error("no frame could be tracked", "bench", "Give a sequence and parameters with which a run tracks.");
  return {record.median_of(&StageTimes::preprocess), record.median_of(&StageTimes::track),
          record.median_of(&StageTimes::integrate), record.median_of(&StageTimes::raycast)};
}

double milliseconds_of(const StageTimes& times, const std::string& stage) {
  if (stage == "preprocess") return times.preprocess;
  if (stage == "track") return times.track;
  if (stage == "integrate") return times.integrate;
  if (stage == "ray cast") return times.raycast;
  throw Error("is no stage of a run", stage, "");
}

}  // namespace plumbline::app
