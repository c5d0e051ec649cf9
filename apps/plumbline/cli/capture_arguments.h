// The options of the devices that `record` and `run live:` capture from.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/depth_device.h"
#include "capture/frame_grabber.h"
#include "capture/imu_source.h"
#include "plumbline/pinhole.h"

namespace CLI {
class App;
}

namespace plumbline::app {

struct CaptureArguments {
  std::string depth = "openni2", imu = "none", imu_calibration;
  double imu_rate = capture::ImuSourceOptions{}.rate;
  double speed = 1;
};

void add_capture_arguments(CLI::App& command, CaptureArguments& arguments);

/// Opens the camera; null for `--depth none`. `capacity`: see FrameGrabber. Throws UsageError for options that are not
/// of their form, Error if there is no such camera.
std::unique_ptr<capture::FrameGrabber> open_depth(const CaptureArguments& arguments, bool color,
                                                  const std::optional<Pinhole>& intrinsics, std::size_t capacity);

/// Connects the orientation sensor; null for `--imu none`.
std::unique_ptr<capture::ImuSource> open_imu(const CaptureArguments& arguments, capture::ImuSource::Sink sink);

/// "sys 3 gyro 3 acc 1 mag 2".
std::string calibration_text(const capture::CalibrationStatus& status);

/// "calibrated: sys 3 …", or what begins with "not".
std::string sensor_text(const capture::ImuStatus& status);

/// Tells when a camera falls silent and when it comes back.
class SilenceWatch {
 public:
  /// A sentence when that changes.
  std::optional<std::string> observe(const capture::GrabberStatus& status);

 private:
  double longest_ = 0;  // seconds, of the silence that goes on
  bool told_ = false;
};

/// How many events a second, over the latest seconds.
class RateMeter {
 public:
  double update(std::uint64_t count, double seconds);

 private:
  std::uint64_t count_ = 0;
  double seconds_ = 0, rate_ = 0;
};

}  // namespace plumbline::app
