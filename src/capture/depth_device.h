// Depth cameras, whatever library speaks to them.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "plumbline/image.h"
#include "plumbline/pinhole.h"
#include "plumbline/time.h"

namespace plumbline::capture {

struct CapturedFrame {
  Nanoseconds time = 0;        ///< of the depth image, monotonic
  DepthImage depth;            ///< raw readings, 0 = none
  Nanoseconds color_time = 0;  ///< of the colour image, if there is one
  ColorImage color;            ///< empty, or registered to the depth image
};

struct DepthDeviceInfo {
  std::string name;                ///< for people
  Pinhole camera;                  ///< of the images
  std::string camera_source;       ///< where it comes from, in words
  double depth_scale = 1000;       ///< readings per metre
  bool has_color = false;          ///< whether frames come with colour
  bool waits = false;              ///< a file that is played as fast as it is read: nothing need be dropped
  std::vector<std::string> notes;  ///< what the user should know
};

/// A camera, or a stand-in for one. One thread at a time; destroyed in the thread that made it.
class DepthDevice {
 public:
  virtual ~DepthDevice() = default;

  const DepthDeviceInfo& info() const { return info_; }
  /// The next frame, or nothing if none came within the time. Throws Error if the camera is lost.
  virtual std::optional<CapturedFrame> wait(std::chrono::milliseconds timeout) = 0;
  /// Whether no frame will ever come again: the end of a file.
  virtual bool ended() const { return false; }
  /// Frames that the camera took, as far as it tells, and that never reached us.
  virtual std::uint64_t missed() const { return 0; }
  /// How often the camera's clock was seen to jump.
  virtual int clock_jumps() const { return 0; }

 protected:
  DepthDeviceInfo info_;
};

struct DepthDeviceOptions {
  std::string device;  ///< virtual:DIR, openni2, openni2:FILE.oni, openni2:URI, freenect, freenect:INDEX
  bool color = true;
  double speed = 1;                        ///< of what is played from files; 0 = as fast as it is read
  std::optional<Pinhole> intrinsics = {};  ///< in place of the device's own; width and height may be 0
};

/// Opens a camera and starts it. Throws Error if there is none, or this program was built without its library.
std::unique_ptr<DepthDevice> open_depth_device(const DepthDeviceOptions& options);

/// Readings at another scale, rounded; what does not fit in 16 bits is no reading.
DepthImage at_scale(DepthImage depth, double from, double to);

}  // namespace plumbline::capture
