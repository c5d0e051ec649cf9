#include "reconstruction/frame_source.h"

#include <algorithm>
#include <utility>

#include "plumbline/time.h"

namespace plumbline {
namespace {

// The sensor's clock may be off by as much, which the tracker finds out.
constexpr Nanoseconds kAroundFrame = kNanosecondsPerSecond / 5;

}  // namespace

std::vector<int> chosen_frames(const Sequence& sequence, int max_frames, int stride) {
  std::vector<int> indices;
  for (int i = 0; i < sequence.size(); i += stride) {
    if (max_frames > 0 && static_cast<int>(indices.size()) == max_frames) break;
    indices.push_back(i);
  }
  return indices;
}

std::vector<int> frames_outside(const Sequence& sequence, const std::vector<TimeSpan>& spans, std::vector<int> frames) {
  std::erase_if(frames, [&](int frame) {
    const double seconds = to_seconds(sequence.time(frame) - sequence.time(0));
    return std::any_of(spans.begin(), spans.end(),
                       [&](const TimeSpan& span) { return seconds >= span.from && seconds < span.to; });
  });
  return frames;
}

FileSource::FileSource(std::unique_ptr<Sequence> sequence, std::vector<int> indices, const OrientationStream* stream,
                       std::vector<std::string> lines, const ImuStream* inertial)
    : sequence_(std::move(sequence)),
      total_(static_cast<int>(indices.size())),
      stream_(stream),
      inertial_(inertial),
      lines_(std::move(lines)),
      reader_(*sequence_, std::move(indices)) {}

std::optional<Frame> FileSource::next(const std::function<bool()>& stopping) {
  if (stopping()) return std::nullopt;
  std::optional<Frame> frame = reader_.next();
  if (frame && stream_ != nullptr) reading_ = add_orientation(*stream_, &*frame);
  if (frame && inertial_ != nullptr) {
    frame->inertial =
        inertial_->between(previous_time_.value_or(frame->time) - kAroundFrame, frame->time + kAroundFrame);
    previous_time_ = frame->time;
  }
  return frame;
}

std::vector<std::string> FileSource::take_messages() {
  std::vector<std::string> messages;
  for (; told_ < reader_.skipped().size(); ++told_) messages.push_back("frame skipped: " + reader_.skipped()[told_]);
  return messages;
}

std::optional<Eigen::Matrix3d> FileSource::earth_from_camera(Nanoseconds time) const {
  if (stream_ == nullptr || !stream_->options().convention.has_up) return std::nullopt;
  const OrientationReading reading = stream_->lookup(time);
  if (reading.status != OrientationStatus::ok) return std::nullopt;
  return reading.earth_from_camera;
}

std::optional<OrientationStreamOptions> FileSource::orientation() const {
  if (stream_ == nullptr) return std::nullopt;
  return stream_->options();
}

}  // namespace plumbline
