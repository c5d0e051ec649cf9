// Structured-light cameras through OpenNI 2: PrimeSense, Asus Xtion, Orbbec, and recordings (.oni).
#include <OpenNI.h>
#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <utility>

#include "capture/clock.h"
#include "capture/color_pairing.h"
#include "capture/drivers.h"
#include "io/text_file.h"
#include "plumbline/error.h"
#include "plumbline/image.h"
#include "plumbline/time.h"

namespace plumbline::capture {
namespace {

constexpr int kUsualWidth = 640, kUsualHeight = 480, kUsualRate = 30;
constexpr float kUsualFieldOfView = 1.0472f;  // radians across, of a Kinect's 525 pixels for 640

/// The library is started with the first and ended with the last of these.
struct Library {
  Library() {
    if (openni::OpenNI::initialize() != openni::STATUS_OK)
      throw Error("the library cannot be started: " + text(), "openni2", "check the installation of libopenni2-0");
  }
  ~Library() { openni::OpenNI::shutdown(); }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

  /// The library's own words for its latest error, without its line ends.
  static std::string text() {
    const std::string message = openni::OpenNI::getExtendedError();
    const std::string_view text = trim(message);
    return text.empty() ? "no reason given" : std::string(text);
  }
};

/// Whether a device was pulled out, or a recording is through.
class EndWatch : public openni::OpenNI::DeviceDisconnectedListener, public openni::OpenNI::DeviceStateChangedListener {
 public:
  explicit EndWatch(std::string uri) : uri_(std::move(uri)) {
    openni::OpenNI::addDeviceDisconnectedListener(this);
    openni::OpenNI::addDeviceStateChangedListener(this);
  }
  ~EndWatch() override {
    openni::OpenNI::removeDeviceStateChangedListener(this);
    openni::OpenNI::removeDeviceDisconnectedListener(this);
  }
  EndWatch(const EndWatch&) = delete;
  EndWatch& operator=(const EndWatch&) = delete;

  void onDeviceDisconnected(const openni::DeviceInfo* device) override {
    if (uri_ == device->getUri()) unplugged = true;
  }
  void onDeviceStateChanged(const openni::DeviceInfo* device, openni::DeviceState state) override {
    if (uri_ == device->getUri() && state == openni::DEVICE_STATE_EOF) at_end = true;
  }
  std::atomic<bool> unplugged = false, at_end = false;

 private:
  std::string uri_;
};

/// A row may be longer in memory than the image is wide.
template <class T>
Image<T> copy_image(const openni::VideoFrameRef& frame, int channels) {
  Image<T> image(frame.getWidth(), frame.getHeight(), channels);
  for (int y = 0; y < image.height; ++y)
    std::memcpy(image.row(y), static_cast<const char*>(frame.getData()) + y * frame.getStrideInBytes(),
                sizeof(T) * static_cast<std::size_t>(image.width * channels));
  return image;
}

class OpenNi2Device : public DepthDevice {
 public:
  OpenNi2Device(const std::string& uri, const DepthDeviceOptions& options)
      : is_file_(std::filesystem::exists(uri)), pairing_(false) {
    if (device_.open(uri.empty() ? openni::ANY_DEVICE : uri.c_str()) != openni::STATUS_OK)
      fail(uri.empty() ? "no camera was found" : "cannot be opened");
    watch_ = std::make_unique<EndWatch>(device_.getDeviceInfo().getUri());
    start_depth();
    if (options.color && device_.hasSensor(openni::SENSOR_COLOR)) start_color();
    pairing_ = ColorPairing(info_.has_color);
    if (is_file_) set_up_playback(options.speed);
    describe();
    apply(options, &info_);
    if (depth_.start() != openni::STATUS_OK) fail("depth cannot be started");
    if (info_.has_color && color_.start() != openni::STATUS_OK) fail("colour cannot be started");
  }

  ~OpenNi2Device() override {
    color_.destroy();
    depth_.destroy();
    watch_.reset();
    device_.close();
  }
  OpenNi2Device(const OpenNi2Device&) = delete;
  OpenNi2Device& operator=(const OpenNi2Device&) = delete;

  std::optional<CapturedFrame> wait(std::chrono::milliseconds timeout) override {
    for (const Nanoseconds limit = now() + std::chrono::nanoseconds(timeout).count();;) {
      if (auto frame = pairing_.take()) {
        const Nanoseconds shift = is_file_ ? file_shift_ : clock_.shift();
        frame->time += shift;
        frame->color_time += shift;
        return frame;
      }
      if (watch_->unplugged) fail("the camera was unplugged");
      const auto left = static_cast<int>((limit - now()) / 1'000'000);
      if (left <= 0 || ended()) return std::nullopt;
      openni::VideoStream* streams[] = {&depth_, &color_};
      int ready = -1;
      const auto status = openni::OpenNI::waitForAnyStream(streams, info_.has_color ? 2 : 1, &ready, left);
      if (status == openni::STATUS_TIME_OUT) return std::nullopt;
      if (status != openni::STATUS_OK) fail("the camera gives no frames");
      read(*streams[ready], ready == 0);
    }
  }

  bool ended() const override { return is_file_ && watch_->at_end; }
  std::uint64_t missed() const override { return missed_; }
  int clock_jumps() const override { return clock_.jumps(); }

 private:
  void start_depth() {
    if (depth_.create(device_, openni::SENSOR_DEPTH) != openni::STATUS_OK) fail("it has no depth");
    if (!is_file_) choose_mode(depth_, {openni::PIXEL_FORMAT_DEPTH_1_MM, openni::PIXEL_FORMAT_DEPTH_100_UM});
    const openni::PixelFormat format = depth_.getVideoMode().getPixelFormat();
    if (format != openni::PIXEL_FORMAT_DEPTH_1_MM && format != openni::PIXEL_FORMAT_DEPTH_100_UM)
      fail("its depth is in a format that is not known");
    info_.depth_scale = format == openni::PIXEL_FORMAT_DEPTH_1_MM ? 1e3 : 1e4;
    depth_.setMirroringEnabled(false);  // a mirrored scene is another scene
  }

  void start_color() {
    if (color_.create(device_, openni::SENSOR_COLOR) != openni::STATUS_OK) fail("colour cannot be had");
    if (!is_file_) choose_mode(color_, {openni::PIXEL_FORMAT_RGB888});
    color_.setMirroringEnabled(false);
    const openni::VideoMode mode = color_.getVideoMode(), depth = depth_.getVideoMode();
    const bool fits = mode.getPixelFormat() == openni::PIXEL_FORMAT_RGB888 &&
                      mode.getResolutionX() == depth.getResolutionX() &&
                      mode.getResolutionY() == depth.getResolutionY();
    constexpr auto kRegistered = openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR;
    if (!is_file_ && device_.isImageRegistrationModeSupported(kRegistered))
      device_.setImageRegistrationMode(kRegistered);
    registered_ = device_.getImageRegistrationMode() == kRegistered;
    if (fits && (registered_ || is_file_)) {
      device_.setDepthColorSyncEnabled(true);
      info_.has_color = true;
      return;
    }
    color_.destroy();
    info_.notes.emplace_back("colour is not registered to depth, or of another size; going on without it");
  }

  /// 640×480 at 30 frames a second in the first of the formats that there is; else the mode stays what it is.
  static void choose_mode(openni::VideoStream& stream, std::initializer_list<openni::PixelFormat> formats) {
    const auto& modes = stream.getSensorInfo().getSupportedVideoModes();
    for (const openni::PixelFormat format : formats)
      for (int i = 0; i < modes.getSize(); ++i)
        if (modes[i].getResolutionX() == kUsualWidth && modes[i].getResolutionY() == kUsualHeight &&
            modes[i].getFps() == kUsualRate && modes[i].getPixelFormat() == format &&
            stream.setVideoMode(modes[i]) == openni::STATUS_OK)
          return;
  }

  void set_up_playback(double speed) {
    if (speed == 0)
      throw Error("a recording of OpenNI plays at a speed", "openni2", "give --speed 1, or more to be through sooner");
    openni::PlaybackControl* const playback = device_.getPlaybackControl();
    if (playback == nullptr) fail("is no recording of OpenNI");
    playback->setRepeatEnabled(false);
    if (playback->setSpeed(static_cast<float>(speed)) != openni::STATUS_OK) fail("cannot be played at that speed");
  }

  void describe() {
    const openni::VideoMode mode = depth_.getVideoMode();
    const float width = static_cast<float>(mode.getResolutionX()), height = static_cast<float>(mode.getResolutionY());
    // Depth that is registered to colour is seen by the colour camera.
    const openni::VideoStream& eye = info_.has_color && registered_ ? color_ : depth_;
    const float reported = eye.getHorizontalFieldOfView();
    const bool known = reported > 0.1f && reported < 3.0f;
    // Pixels are square; the vertical field of view follows.
    const float f = 0.5f * width / std::tan(0.5f * (known ? reported : kUsualFieldOfView));
    info_.camera = {f, f, 0.5f * (width - 1), 0.5f * (height - 1), mode.getResolutionX(), mode.getResolutionY()};
    info_.camera_source = known ? "the field of view that it reports" : "a Kinect's field of view, as it reports none";
    const openni::DeviceInfo& info = device_.getDeviceInfo();
    info_.name = fmt::format("{} {} (OpenNI2), {}", info.getVendor(), info.getName(), info.getUri());
  }

  void read(openni::VideoStream& stream, bool is_depth) {
    openni::VideoFrameRef frame;
    if (stream.readFrame(&frame) != openni::STATUS_OK) fail("a frame cannot be read");
    const Nanoseconds time = 1000 * static_cast<Nanoseconds>(frame.getTimestamp());
    if (file_shift_ == 0) file_shift_ = now() - time;
    if (!is_depth) return pairing_.add_color(time, copy_image<std::uint8_t>(frame, 3));
    clock_.to_host(time, now());
    if (previous_index_ > 0 && frame.getFrameIndex() > previous_index_ + 1)
      missed_ += static_cast<std::uint64_t>(frame.getFrameIndex() - previous_index_ - 1);
    previous_index_ = frame.getFrameIndex();
    pairing_.add_depth(time, copy_image<std::uint16_t>(frame, 1));
  }

  [[noreturn]] void fail(const char* what) const {
    throw Error(fmt::format("{} ({})", what, Library::text()), "openni2",
                "check that the camera is plugged in and that no other program uses it");
  }

  Library library_;
  bool is_file_, registered_ = false;
  openni::Device device_;
  openni::VideoStream depth_, color_;
  std::unique_ptr<EndWatch> watch_;
  ColorPairing pairing_;
  DeviceClock clock_;
  Nanoseconds file_shift_ = 0;  // a recording goes on in its own time, from the moment when it is played
  int previous_index_ = 0;
  std::uint64_t missed_ = 0;
};

}  // namespace

std::unique_ptr<DepthDevice> make_openni2_device(const std::string& uri, const DepthDeviceOptions& options) {
  return std::make_unique<OpenNi2Device>(uri, options);
}

}  // namespace plumbline::capture
