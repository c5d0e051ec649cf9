// Frames straight from a camera, each with the orientation that a sensor had at its time.
#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "cli/capture_arguments.h"
#include "plumbline/frame.h"
#include "plumbline/orientation.h"
#include "plumbline/pinhole.h"
#include "plumbline/time.h"
#include "reconstruction/frame_source.h"

namespace plumbline::app {

/// Gives the latest frame alone: those that came while the previous one was worked on are dropped and counted.
class LiveSource : public FrameSource {
 public:
  /// Opens the devices, throwing what that throws. `max_frames` 0 is no limit; `orientation` says how the sensor's
  /// readings are to be taken.
  LiveSource(const CaptureArguments& arguments, bool color, const std::optional<Pinhole>& intrinsics, int max_frames,
             const OrientationStreamOptions& orientation, DepthDistortion distortion);

  SequenceInfo info() const override;
  std::vector<std::string> describe() const override;
  bool has_color() const override { return camera_->info().has_color; }
  int total() const override { return max_frames_ > 0 ? max_frames_ : -1; }
  std::optional<Frame> next(const std::function<bool()>& stopping) override;
  ReadTimes read_times() const override { return {wait_milliseconds_, 0}; }
  std::optional<OrientationReading> reading() const override { return reading_; }
  std::optional<OrientationStreamOptions> orientation() const override;
  std::optional<LiveCounts> live() const override;
  std::string sensor_state() const override;
  std::vector<std::string> take_messages() override;

 private:
  void add(const capture::ImuReading& reading);
  void look_up(Frame* frame);
  std::vector<OrientationSample> samples_around(Nanoseconds time);

  std::string name_;
  Nanoseconds unix_offset_;  // stamps are seconds since 1970, as in recordings
  int max_frames_, count_ = 0;
  OrientationStreamOptions orientation_;
  DepthDistortion distortion_;
  double wait_milliseconds_ = 0;
  std::optional<OrientationReading> reading_;
  SilenceWatch silence_;

  std::mutex mutex_;
  std::deque<OrientationSample> samples_;  // guarded by mutex_; of the latest seconds
  std::unique_ptr<capture::FrameGrabber> camera_;
  std::unique_ptr<capture::ImuSource> imu_;  // last: its thread adds samples
};

}  // namespace plumbline::app
