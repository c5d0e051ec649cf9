#include "run/live_source.h"

#include <fmt/format.h>

#include <thread>
#include <utility>

#include "capture/clock.h"
#include "cli/arguments.h"
#include "cli/sequence_text.h"
#include "plumbline/frame.h"
#include "plumbline/orientation.h"
#include "plumbline/pinhole.h"
#include "plumbline/time.h"

namespace plumbline::app {
namespace {

constexpr std::chrono::milliseconds kPoll{50};
constexpr Nanoseconds kKept = 3 * kNanosecondsPerSecond;  // of readings
constexpr Nanoseconds kReadingWait = 40'000'000;          // for the reading after a frame, to interpolate

}  // namespace

LiveSource::LiveSource(const CaptureArguments& arguments, bool color, const std::optional<Pinhole>& intrinsics,
                       int max_frames, const OrientationStreamOptions& orientation, DepthDistortion distortion)
    : name_("live:" + arguments.depth),
      unix_offset_(capture::unix_offset()),
      max_frames_(max_frames),
      orientation_(orientation),
      distortion_(std::move(distortion)) {
  camera_ = open_depth(arguments, color, intrinsics, 1);
  if (camera_ == nullptr)
    throw UsageError("a reconstruction needs a camera", "--depth none", "Give --depth openni2 or another camera.");
  if (!distortion_.empty()) distortion_.check_size(camera_->info().camera.width, camera_->info().camera.height);
  imu_ = open_imu(arguments, [this](const capture::ImuReading& reading) { add(reading); });
}

SequenceInfo LiveSource::info() const {
  const capture::DepthDeviceInfo& device = camera_->info();
  SequenceInfo info;
  info.path = name_;
  info.format = "live";
  info.camera = device.camera;
  info.camera_source = device.camera_source;
  info.depth_scale = device.depth_scale;
  info.depth_scale_source = "the camera";
  info.frames = info.color_frames = static_cast<int>(camera_->status().frames);
  if (!device.has_color) info.color_frames = 0;
  info.notes = device.notes;
  return info;
}

std::vector<std::string> LiveSource::describe() const {
  const capture::DepthDeviceInfo& device = camera_->info();
  std::vector<std::string> lines = {fmt::format("live       {}, {}; Ctrl-C ends the run", device.name,
                                                device.has_color ? "with colour" : "no colour"),
                                    fmt::format("camera     {}", camera_text(device.camera)),
                                    fmt::format("           from {}", device.camera_source)};
  for (const std::string& note : device.notes) lines.push_back("note       " + note);
  if (!distortion_.empty()) lines.push_back("note       " + distortion_.describe() + " is taken out");
  if (imu_) lines.push_back("sensor     " + imu_->description());
  return lines;
}

std::optional<Frame> LiveSource::next(const std::function<bool()>& stopping) {
  if (max_frames_ > 0 && count_ == max_frames_) return std::nullopt;
  const Nanoseconds begin = capture::now();
  while (!stopping() && !camera_->status().ended) {
    std::optional<capture::CapturedFrame> captured = camera_->next(kPoll);
    if (!captured) continue;
    Frame frame{count_++, captured->time + unix_offset_, std::move(captured->depth), camera_->info().depth_scale,
                std::move(captured->color)};
    distortion_.correct(frame.depth_scale, &frame.depth);
    if (imu_) look_up(&frame);
    wait_milliseconds_ = 1e3 * to_seconds(capture::now() - begin);
    return frame;
  }
  return std::nullopt;
}

void LiveSource::add(const capture::ImuReading& reading) {
  const OrientationSample sample{reading.time + unix_offset_,
                                 decode_orientation(reading.quaternion, orientation_.convention)};
  const std::lock_guard lock(mutex_);
  if (!samples_.empty() && samples_.back().time >= sample.time) return;
  samples_.push_back(sample);
  while (samples_.front().time < sample.time - kKept) samples_.pop_front();
}

std::vector<OrientationSample> LiveSource::samples_around(Nanoseconds time) {
  for (const Nanoseconds limit = capture::now() + kReadingWait;;) {
    {
      const std::lock_guard lock(mutex_);
      const bool ready = !samples_.empty() && samples_.back().time + from_seconds(orientation_.time_offset) >= time;
      if (ready || capture::now() > limit) return {samples_.begin(), samples_.end()};
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

void LiveSource::look_up(Frame* frame) {
  std::vector<OrientationSample> samples = samples_around(frame->time);
  reading_ = OrientationReading{OrientationStatus::before_start};
  if (!samples.empty()) reading_ = add_orientation(OrientationStream(std::move(samples), orientation_), frame);
}

std::optional<OrientationStreamOptions> LiveSource::orientation() const {
  if (imu_ == nullptr) return std::nullopt;
  return orientation_;
}

std::optional<LiveCounts> LiveSource::live() const {
  const capture::GrabberStatus status = camera_->status();
  return LiveCounts{status.frames, status.dropped};
}

std::string LiveSource::sensor_state() const { return imu_ ? sensor_text(imu_->status()) : ""; }

std::vector<std::string> LiveSource::take_messages() {
  std::vector<std::string> messages;
  if (imu_) messages = imu_->take_messages();
  if (auto message = silence_.observe(camera_->status())) messages.push_back(std::move(*message));
  return messages;
}

}  // namespace plumbline::app
