// Frames as a live page lets them through: held while the run stands still, ended when it is to go back or to end.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "plumbline/frame.h"
#include "reconstruction/frame_source.h"
#include "view/live_view.h"

namespace plumbline::app {

/// Where a run goes back to.
struct GoBack {
  std::optional<double> seconds;  ///< to be undone; none: all
};

/// A recording's frames by their indices, read once more.
using Reopen = std::function<std::unique_ptr<FrameSource>(std::vector<int> frames, bool in_real_time)>;

/// Takes what the page asks for between two frames. Undoing means that the frames that stay are processed once more, in
/// their order, by a new pipeline: the map is then, to the bit, what it was. A recording's are read again and it goes
/// on from there; a camera's are kept in memory as long as there is room, and it goes on with what it sees now.
class GuidedSource : public FrameSource {
 public:
  /// `reopen`: of a recording, whose frames are `frames`; null for a camera, which waits for a start. `view` must
  /// outlive it.
  GuidedSource(std::unique_ptr<FrameSource> source, Reopen reopen, std::vector<int> frames, LiveView* view);

  SequenceInfo info() const override { return source_->info(); }
  std::vector<std::string> describe() const override { return source_->describe(); }
  bool has_color() const override { return source_->has_color(); }
  int total() const override { return source_->total(); }
  std::optional<Frame> next(const std::function<bool()>& stopping) override;
  ReadTimes read_times() const override { return replay_ ? ReadTimes() : source_->read_times(); }
  std::optional<OrientationReading> reading() const override { return reading_; }
  std::optional<OrientationStreamOptions> orientation() const override { return source_->orientation(); }
  std::optional<LiveCounts> live() const override { return source_->live(); }
  const Sequence* recording() const override { return source_->recording(); }
  std::vector<std::string> skipped() const override { return source_->skipped(); }
  std::string sensor_state() const override { return source_->sensor_state(); }
  std::vector<std::string> take_messages() override { return source_->take_messages(); }

  /// Why the frames ended, if the run is to go back; once.
  std::optional<GoBack> take_back();
  /// Of the frames that were processed, by their indices, the first `kept` stay; they come next, for a new pipeline.
  void go_back(const std::vector<int>& processed, std::size_t kept);

 private:
  struct Kept {
    Frame frame;
    std::optional<OrientationReading> reading;
  };
  bool obey(const Request& request);
  std::optional<Frame> stand_still(const std::function<bool()>& stopping);
  std::optional<Frame> replay(const std::function<bool()>& stopping);
  void keep(const Frame& frame);
  void set_held(bool held);

  std::unique_ptr<FrameSource> source_, replay_;
  Reopen reopen_;
  std::vector<int> frames_;
  LiveView& view_;
  bool held_ = false, finished_ = false, is_new_ = true;
  std::optional<GoBack> back_;
  std::optional<OrientationReading> reading_;
  std::deque<Kept> kept_;  ///< of a camera
  std::size_t kept_bytes_ = 0;
  std::size_t replayed_ = 0, to_replay_ = 0;
};

}  // namespace plumbline::app
