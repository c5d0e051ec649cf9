// Microsoft's first Kinect through libfreenect.
#include <libfreenect.h>
#include <sys/time.h>

#include <charconv>
#include <cstring>
#include <utility>

#include "capture/clock.h"
#include "capture/color_pairing.h"
#include "capture/drivers.h"
#include "plumbline/error.h"
#include "plumbline/image.h"
#include "plumbline/pinhole.h"
#include "plumbline/time.h"

namespace plumbline::capture {
namespace {

constexpr int kWidth = 640, kHeight = 480;
// The colour camera's, to which the library registers depth; single Kinects differ by 1 to 2 %.
constexpr Pinhole kColorCamera{525.0f, 525.0f, 319.5f, 239.5f, kWidth, kHeight};
constexpr std::int64_t kTicksPerSecond = 60'000'000;

/// The camera stamps with 32 bits that run over every 71 seconds, depth and colour by one clock.
class TickCounter {
 public:
  Nanoseconds nanoseconds(std::uint32_t ticks) {
    // Images of the two kinds may come out of order.
    ticks_ += static_cast<std::int32_t>(ticks - previous_);
    previous_ = ticks;
    return ticks_ / kTicksPerSecond * kNanosecondsPerSecond + ticks_ % kTicksPerSecond * 1000 / 60;
  }

 private:
  std::int64_t ticks_ = std::int64_t{1} << 32;
  std::uint32_t previous_ = 0;
};

class FreenectDevice : public DepthDevice {
 public:
  FreenectDevice(int index, const DepthDeviceOptions& options) : pairing_(options.color) {
    if (freenect_init(&context_, nullptr) < 0) fail("USB cannot be used");
    freenect_set_log_callback(context_, [](freenect_context*, freenect_loglevel, const char*) {});
    freenect_select_subdevices(context_, FREENECT_DEVICE_CAMERA);
    if (freenect_num_devices(context_) <= index) fail("no Kinect was found");
    if (freenect_open_device(context_, &device_, index) < 0) fail("the Kinect cannot be opened");
    freenect_set_user(device_, this);
    start_depth();
    if (options.color) start_color();
    info_.name = "Kinect (libfreenect)";
    info_.camera = kColorCamera;
    info_.camera_source = "the Kinect's default; depth is registered to colour";
    info_.depth_scale = 1000;
    info_.has_color = options.color;
    apply(options, &info_);
  }

  ~FreenectDevice() override { shut_down(); }
  FreenectDevice(const FreenectDevice&) = delete;
  FreenectDevice& operator=(const FreenectDevice&) = delete;

  std::optional<CapturedFrame> wait(std::chrono::milliseconds timeout) override {
    for (const Nanoseconds limit = now() + std::chrono::nanoseconds(timeout).count();;) {
      if (auto frame = pairing_.take()) {
        frame->time += clock_.shift();
        frame->color_time += clock_.shift();
        return frame;
      }
      const Nanoseconds left = limit - now();
      if (left <= 0) return std::nullopt;
      timeval time{0, static_cast<suseconds_t>(left / 1000)};
      if (freenect_process_events_timeout(context_, &time) < 0)
        throw Error("the Kinect does not answer any more", "freenect", "check its cable and its power supply");
    }
  }

  int clock_jumps() const override { return clock_.jumps(); }

 private:
  void start_depth() {
    const freenect_frame_mode mode = freenect_find_depth_mode(FREENECT_RESOLUTION_MEDIUM, FREENECT_DEPTH_REGISTERED);
    freenect_set_depth_callback(device_, [](freenect_device* device, void* data, std::uint32_t stamp) {
      static_cast<FreenectDevice*>(freenect_get_user(device))->on_depth(data, stamp);
    });
    if (freenect_set_depth_mode(device_, mode) < 0 || freenect_start_depth(device_) < 0)
      fail("the depth camera cannot be started");
  }

  void start_color() {
    const freenect_frame_mode mode = freenect_find_video_mode(FREENECT_RESOLUTION_MEDIUM, FREENECT_VIDEO_RGB);
    freenect_set_video_callback(device_, [](freenect_device* device, void* data, std::uint32_t stamp) {
      static_cast<FreenectDevice*>(freenect_get_user(device))->on_color(data, stamp);
    });
    if (freenect_set_video_mode(device_, mode) < 0 || freenect_start_video(device_) < 0)
      fail("the colour camera cannot be started");
  }

  void on_depth(const void* data, std::uint32_t stamp) {
    DepthImage image(kWidth, kHeight);
    std::memcpy(image.pixels.data(), data, sizeof(std::uint16_t) * image.pixels.size());
    const Nanoseconds time = ticks_.nanoseconds(stamp);
    clock_.to_host(time, now());
    pairing_.add_depth(time, std::move(image));
  }

  void on_color(const void* data, std::uint32_t stamp) {
    ColorImage image(kWidth, kHeight, 3);
    std::memcpy(image.pixels.data(), data, image.pixels.size());
    pairing_.add_color(ticks_.nanoseconds(stamp), std::move(image));
  }

  [[noreturn]] void fail(const char* what) {
    shut_down();
    throw Error(what, "freenect", "check its cable and its power supply, and that no other program uses it");
  }

  void shut_down() {
    if (device_ != nullptr) {
      freenect_stop_depth(device_);
      if (info_.has_color) freenect_stop_video(device_);
      freenect_close_device(device_);
    }
    if (context_ != nullptr) freenect_shutdown(context_);
    device_ = nullptr;
    context_ = nullptr;
  }

  freenect_context* context_ = nullptr;
  freenect_device* device_ = nullptr;
  ColorPairing pairing_;
  TickCounter ticks_;
  DeviceClock clock_;
};

}  // namespace

std::unique_ptr<DepthDevice> make_freenect_device(const std::string& index, const DepthDeviceOptions& options) {
  int number = 0;
  const auto [end, error] = std::from_chars(index.data(), index.data() + index.size(), number);
  if (!index.empty() && (error != std::errc() || end != index.data() + index.size() || number < 0))
    throw Error("is no number of a Kinect", "freenect:" + index, "give freenect, or freenect:1 for the second");
  return std::make_unique<FreenectDevice>(number, options);
}

}  // namespace plumbline::capture
