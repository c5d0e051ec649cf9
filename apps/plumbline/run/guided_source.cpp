#include "run/guided_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

namespace plumbline::app {
namespace {

constexpr std::chrono::milliseconds kStandingPoll{15};
constexpr std::size_t kMaxKept = std::size_t{1} << 30;  ///< bytes: some 20 seconds of 640x480 with colour

std::size_t bytes_of(const Frame& frame) {
  return frame.depth.pixels.size() * sizeof(frame.depth.pixels[0]) + frame.color.pixels.size();
}

}  // namespace

GuidedSource::GuidedSource(std::unique_ptr<FrameSource> source, Reopen reopen, std::vector<int> frames, LiveView* view)
    : source_(std::move(source)), reopen_(std::move(reopen)), frames_(std::move(frames)), view_(*view) {
  held_ = reopen_ == nullptr;
  view_.set_phase(held_ ? ViewPhase::ready : ViewPhase::running);
  view_.set_undo("");
}

std::optional<Frame> GuidedSource::next(const std::function<bool()>& stopping) {
  if (to_replay_ > 0) {
    if (auto frame = replay(stopping)) return frame;
    if (stopping()) return std::nullopt;
    to_replay_ = 0;
    replay_.reset();
    set_held(true);
  }
  while (const std::optional<Request> request = view_.take_request())
    if (!obey(*request)) return std::nullopt;
  if (held_) return stand_still(stopping);
  std::optional<Frame> frame = source_->next(stopping);
  reading_ = source_->reading();
  view_.set_sensor(source_->sensor_state());
  if (frame) keep(*frame);
  return frame;
}

/// False if the frames end here.
bool GuidedSource::obey(const Request& request) {
  switch (request.kind) {
    case RequestKind::pause:
      if (!held_) set_held(true);
      return true;
    case RequestKind::start:
    case RequestKind::resume:
      if (held_) set_held(false);
      return true;
    case RequestKind::undo:
      if (reopen_ == nullptr && kept_.empty()) return true;  // the page knows why not
      back_ = GoBack{request.seconds};
      return false;
    case RequestKind::reset:
      back_ = GoBack{std::nullopt};
      return false;
    default:
      finished_ = true;
      return false;
  }
}

void GuidedSource::set_held(bool held) {
  held_ = held;
  if (!held) is_new_ = false;
  const bool waits = held && is_new_ && reopen_ == nullptr;
  view_.set_phase(waits ? ViewPhase::ready : held ? ViewPhase::paused : ViewPhase::running);
}

/// Until the run goes on. A camera's frames pass meanwhile, and are shown.
std::optional<Frame> GuidedSource::stand_still(const std::function<bool()>& stopping) {
  const auto begin = std::chrono::steady_clock::now();
  while (held_ && !stopping()) {
    if (reopen_ == nullptr) {
      const std::optional<Frame> frame = source_->next(stopping);
      if (!frame) return std::nullopt;
      view_.show(frame->depth, frame->color, frame->depth_scale);
    } else {
      std::this_thread::sleep_for(kStandingPoll);
    }
    view_.idle();
    while (const std::optional<Request> request = view_.take_request())
      if (!obey(*request)) return std::nullopt;
  }
  if (stopping()) return std::nullopt;
  source_->delay((std::chrono::steady_clock::now() - begin) / std::chrono::nanoseconds(1));
  return next(stopping);
}

std::optional<Frame> GuidedSource::replay(const std::function<bool()>& stopping) {
  if (stopping() || replayed_ == to_replay_) return std::nullopt;
  if (replayed_ % 8 == 0)
    view_.set_phase(ViewPhase::going_back, fmt::format("frame {} of {}", replayed_, to_replay_),
                    static_cast<double>(replayed_) / static_cast<double>(to_replay_));
  ++replayed_;
  if (!replay_) {
    const Kept& kept = kept_[replayed_ - 1];
    reading_ = kept.reading;
    return kept.frame;
  }
  std::optional<Frame> frame = replay_->next(stopping);
  reading_ = replay_->reading();
  return frame;
}

void GuidedSource::keep(const Frame& frame) {
  if (reopen_ != nullptr || kept_bytes_ > kMaxKept) return;
  kept_.push_back({frame, reading_});
  kept_bytes_ += bytes_of(frame);
  if (kept_bytes_ <= kMaxKept) return;
  kept_.clear();
  view_.set_undo("This run is too long to be undone: its frames no longer fit the memory kept for that.");
}

std::optional<GoBack> GuidedSource::take_back() { return std::exchange(back_, std::nullopt); }

void GuidedSource::go_back(const std::vector<int>& processed, std::size_t kept) {
  replayed_ = 0;
  to_replay_ = kept;
  if (reopen_ == nullptr) {
    while (kept_.size() > kept) {
      kept_bytes_ -= bytes_of(kept_.back().frame);
      kept_.pop_back();
    }
    if (kept == 0) {
      kept_.clear();
      kept_bytes_ = 0;
      view_.set_undo("");
    }
  } else {
    const auto again = processed.begin() + static_cast<std::ptrdiff_t>(kept);
    const auto rest = kept == 0 ? frames_.begin() : std::upper_bound(frames_.begin(), frames_.end(), *(again - 1));
    if (kept > 0) replay_ = reopen_({processed.begin(), again}, false);
    source_ = reopen_({rest, frames_.end()}, true);
  }
  is_new_ = kept == 0;
  if (kept == 0) set_held(true);
}

}  // namespace plumbline::app
