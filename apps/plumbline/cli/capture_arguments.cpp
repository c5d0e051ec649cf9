#include "cli/capture_arguments.h"

#include <fmt/format.h>
#include <algorithm>

#include <CLI/CLI.hpp>
#include <utility>

#include "cli/arguments.h"
#include "plumbline/pinhole.h"

namespace plumbline::app {
namespace {

constexpr double kSilence = 2;   // seconds without a frame that are told
constexpr double kRateSpan = 1;  // seconds

}  // namespace

void add_capture_arguments(CLI::App& command, CaptureArguments& a) {
  command
      .add_option("--depth", a.depth,
                  "Depth camera: openni2, openni2:FILE.oni, freenect, virtual:DIR (plays a sequence), or none")
      ->capture_default_str()
      ->type_name("DEVICE");
  command
      .add_option("--imu", a.imu,
                  "Orientation sensor (BNO055): serial:/dev/ttyUSB0, i2c:/dev/i2c-1, i2c:/dev/i2c-1:0x29, or none")
      ->capture_default_str()
      ->type_name("PORT");
  command
      .add_option("--imu-calibration", a.imu_calibration,
                  "imu-calibration.txt of an earlier recording: what the sensor then knew")
      ->type_name("FILE");
  command.add_option("--imu-rate", a.imu_rate, "Readings a second; the chip has up to 100")
      ->check(CLI::Range(1.0, 200.0))
      ->capture_default_str();
  command
      .add_option("--speed", a.speed,
                  "Of a virtual camera and of --realtime: 1 is real time, 0 as fast as frames are taken")
      ->check(CLI::Range(0.0, 1e3))
      ->capture_default_str();
}

std::unique_ptr<capture::FrameGrabber> open_depth(const CaptureArguments& a, bool color,
                                                  const std::optional<Pinhole>& intrinsics, std::size_t capacity) {
  if (a.depth == "none") return nullptr;
  if (a.speed != 1 && a.imu != "none")
    throw UsageError("a sensor that reads in real time does not go with a camera that does not", "--speed",
                     "Leave out --speed or --imu.");
  capture::DepthDeviceOptions options;
  options.device = a.depth;
  options.color = color;
  options.speed = a.speed;
  options.intrinsics = intrinsics;
  return std::make_unique<capture::FrameGrabber>([options] { return capture::open_depth_device(options); }, capacity);
}

std::unique_ptr<capture::ImuSource> open_imu(const CaptureArguments& a, capture::ImuSource::Sink sink) {
  if (a.imu == "none") {
    if (!a.imu_calibration.empty())
      throw UsageError("there is no sensor to calibrate", "--imu-calibration", "Give --imu as well.");
    return nullptr;
  }
  capture::ImuSourceOptions options;
  options.connection = a.imu;
  options.rate = a.imu_rate;
  if (!a.imu_calibration.empty()) options.chip.calibration = capture::read_bno055_calibration(a.imu_calibration);
  return std::make_unique<capture::ImuSource>(options, std::move(sink));
}

std::string calibration_text(const capture::CalibrationStatus& s) {
  return fmt::format("sys {} gyro {} acc {} mag {}", s.system, s.gyroscope, s.accelerometer, s.magnetometer);
}

std::string sensor_text(const capture::ImuStatus& status) {
  if (!status.connected) return "not connected";
  const capture::CalibrationStatus& c = status.calibration;
  const bool is_calibrated = std::min({c.system, c.gyroscope, c.accelerometer}) > 0;
  return (is_calibrated ? "calibrated: " : "not calibrated: ") + calibration_text(c);
}

std::optional<std::string> SilenceWatch::observe(const capture::GrabberStatus& status) {
  if (status.silence > kSilence) {
    longest_ = status.silence;
    if (std::exchange(told_, true)) return std::nullopt;
    return fmt::format("the camera has given no frame for {:g} s; check its cable", kSilence);
  }
  if (!std::exchange(told_, false)) return std::nullopt;
  return fmt::format("the camera gives frames again, after {:.1f} s", longest_);
}

double RateMeter::update(std::uint64_t count, double seconds) {
  if (seconds_ == 0 && seconds > 0) rate_ = static_cast<double>(count) / seconds;
  if (seconds - seconds_ < kRateSpan) return rate_;
  rate_ = static_cast<double>(count - count_) / (seconds - seconds_);
  count_ = count;
  seconds_ = seconds;
  return rate_;
}

}  // namespace plumbline::app
