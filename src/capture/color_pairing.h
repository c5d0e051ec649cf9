// Depth and colour that come one by one, joined to frames.
#pragma once

#include <deque>
#include <optional>

#include "capture/depth_device.h"
#include "plumbline/image.h"
#include "plumbline/time.h"

namespace plumbline::capture {

/// Each depth image gets the colour image nearest before or after it, if that is near enough in time; it waits for it
/// at most until the next depth image. Both are stamped by one clock, the camera's own.
class ColorPairing {
 public:
  /// Without colour no depth image waits.
  explicit ColorPairing(bool has_color) : has_color_(has_color) {}

  void add_depth(Nanoseconds time, DepthImage depth);
  void add_color(Nanoseconds time, ColorImage color);
  /// The oldest frame that is complete.
  std::optional<CapturedFrame> take();

 private:
  bool join(CapturedFrame* frame);

  bool has_color_;
  std::optional<CapturedFrame> waiting_;
  Nanoseconds color_time_ = 0;
  ColorImage color_;  // the latest that has no depth yet
  std::deque<CapturedFrame> complete_;
};

}  // namespace plumbline::capture
