// Where the frames of a run come from: files, or devices.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "plumbline/frame.h"
#include "plumbline/imu_stream.h"
#include "plumbline/orientation_stream.h"
#include "plumbline/prefetch.h"
#include "plumbline/sequence.h"
#include "plumbline/time.h"

namespace plumbline {

/// Of one frame, milliseconds: what the run waited for the reader, and what the reader's thread worked on it.
struct ReadTimes {
  double wait = 0, decode = 0;
};

/// What a live run got from its camera, and could not keep up with.
struct LiveCounts {
  std::uint64_t captured = 0, dropped = 0;
};

/// Every `stride`-th frame of a sequence, `max_frames` at most; 0: no limit.
std::vector<int> chosen_frames(const Sequence& sequence, int max_frames, int stride = 1);

/// A part of a recording, seconds after its first frame; `to` is no longer part of it.
struct TimeSpan {
  double from = 0, to = 0;
};
/// The frames that lie in none of the spans.
std::vector<int> frames_outside(const Sequence& sequence, const std::vector<TimeSpan>& spans, std::vector<int> frames);

class FrameSource {
 public:
  virtual ~FrameSource() = default;

  virtual SequenceInfo info() const = 0;
  /// Lines of "name  value" for people.
  virtual std::vector<std::string> describe() const = 0;
  virtual bool has_color() const = 0;
  /// How many frames there will be; negative if nobody knows.
  virtual int total() const = 0;
  /// The next frame with its orientation, if it has one; nothing after the last, or once `stopping` says so.
  virtual std::optional<Frame> next(const std::function<bool()>& stopping) = 0;
  virtual ReadTimes read_times() const = 0;
  /// Of the latest frame; none without a sensor.
  virtual std::optional<OrientationReading> reading() const = 0;
  /// How the sensor's readings are taken; none without a sensor.
  virtual std::optional<OrientationStreamOptions> orientation() const = 0;
  /// The attitude by the sensor at the time of a frame; none without.
  virtual std::optional<Eigen::Matrix3d> earth_from_camera(Nanoseconds) const { return std::nullopt; }
  virtual std::optional<LiveCounts> live() const { return std::nullopt; }
  /// What the frames are read from, as the run sees it, if they can be read again; else null.
  virtual const Sequence* recording() const { return nullptr; }
  /// Why frames could not be read and were skipped, a sentence each.
  virtual std::vector<std::string> skipped() const { return {}; }
  /// How a live sensor of orientations is, in words; empty where there is nothing to say.
  virtual std::string sensor_state() const { return {}; }
  /// The run has stood still for so many nanoseconds: what plays by a clock goes on from where it was.
  virtual void delay([[maybe_unused]] Nanoseconds time) {}
  /// What happened since the previous call, a sentence each.
  virtual std::vector<std::string> take_messages() { return {}; }
};

/// Frames of a sequence, decoded ahead, with the orientation of a stream.
class FileSource : public FrameSource {
 public:
  /// `stream` and `inertial` may be null and must outlive the source; `lines` describe it.
  FileSource(std::unique_ptr<Sequence> sequence, std::vector<int> indices, const OrientationStream* stream,
             std::vector<std::string> lines, const ImuStream* inertial = nullptr);

  SequenceInfo info() const override { return sequence_->info(); }
  std::vector<std::string> describe() const override { return lines_; }
  bool has_color() const override { return sequence_->info().color_frames > 0; }
  int total() const override { return total_; }
  std::optional<Frame> next(const std::function<bool()>& stopping) override;
  const Sequence* recording() const override { return sequence_.get(); }
  ReadTimes read_times() const override { return {reader_.wait_milliseconds(), reader_.decode_milliseconds()}; }
  std::optional<OrientationReading> reading() const override { return reading_; }
  std::optional<OrientationStreamOptions> orientation() const override;
  std::optional<Eigen::Matrix3d> earth_from_camera(Nanoseconds time) const override;
  std::vector<std::string> skipped() const override { return reader_.skipped(); }
  std::vector<std::string> take_messages() override;

 private:
  std::unique_ptr<Sequence> sequence_;
  int total_;
  const OrientationStream* stream_;
  const ImuStream* inertial_;
  std::optional<Nanoseconds> previous_time_;  ///< of the frame before
  std::vector<std::string> lines_;
  std::optional<OrientationReading> reading_;
  std::size_t told_ = 0;   ///< of reader_.skipped()
  ReadableFrames reader_;  // last: it reads from the sequence
};

}  // namespace plumbline
