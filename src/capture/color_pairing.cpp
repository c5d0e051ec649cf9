#include "capture/color_pairing.h"
#include "plumbline/image.h"
#include "plumbline/time.h"

#include <cstdlib>
#include <utility>

namespace plumbline::capture {
namespace {

constexpr Nanoseconds kNear = 20'000'000;  // as readers of TUM folders take it

}  // namespace

bool ColorPairing::join(CapturedFrame* frame) {
  if (color_.empty() || std::abs(color_time_ - frame->time) > kNear) return false;
  frame->color = std::exchange(color_, {});
  frame->color_time = color_time_;
  return true;
}

void ColorPairing::add_depth(Nanoseconds time, DepthImage depth) {
  if (waiting_) complete_.push_back(std::move(*waiting_));
  waiting_.reset();
  CapturedFrame frame{time, std::move(depth), 0, {}};
  if (!has_color_ || join(&frame))
    complete_.push_back(std::move(frame));
  else
    waiting_ = std::move(frame);
}

void ColorPairing::add_color(Nanoseconds time, ColorImage color) {
  color_ = std::move(color);
  color_time_ = time;
  if (!waiting_ || !join(&*waiting_)) return;
  complete_.push_back(std::move(*waiting_));
  waiting_.reset();
}

std::optional<CapturedFrame> ColorPairing::take() {
  if (complete_.empty()) return std::nullopt;
  CapturedFrame frame = std::move(complete_.front());
  complete_.pop_front();
  return frame;
}

}  // namespace plumbline::capture
