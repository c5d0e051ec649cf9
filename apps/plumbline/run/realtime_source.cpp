#include "run/realtime_source.h"
#include "plumbline/frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <thread>
#include <utility>

namespace plumbline::app {

RealtimeSource::RealtimeSource(std::unique_ptr<FrameSource> frames, double speed)
    : frames_(std::move(frames)), speed_(speed) {}

std::vector<std::string> RealtimeSource::describe() const {
  std::vector<std::string> lines = frames_->describe();
  lines.push_back(
      fmt::format("real time  played at {:g} times its speed; frames that come too fast are dropped", speed_));
  return lines;
}

std::optional<Frame> RealtimeSource::next(const std::function<bool()>& stopping) {
  if (!start_) {
    following_ = read(stopping);
    if (!following_.frame) return std::nullopt;
    first_ = following_.frame->time;
    start_ = Clock::now();
  }
  if (!following_.frame) return std::nullopt;
  current_ = std::exchange(following_, read(stopping));
  while (following_.frame && due(*following_.frame) <= Clock::now()) {
    ++counts_.dropped;
    current_ = std::exchange(following_, read(stopping));
  }
  const Clock::time_point before = Clock::now();
  wait_until(due(*current_.frame), stopping);
  if (stopping()) return std::nullopt;
  current_.times.wait = std::chrono::duration<double, std::milli>(Clock::now() - before).count();
  return std::exchange(current_.frame, std::nullopt);
}

void RealtimeSource::delay(Nanoseconds time) {
  if (start_) *start_ += std::chrono::nanoseconds(time);
}

RealtimeSource::Item RealtimeSource::read(const std::function<bool()>& stopping) {
  Item item;
  item.frame = frames_->next(stopping);
  if (!item.frame) return item;
  ++counts_.captured;
  item.times = frames_->read_times();
  item.reading = frames_->reading();
  return item;
}

RealtimeSource::Clock::time_point RealtimeSource::due(const Frame& frame) const {
  const auto since_first = std::chrono::nanoseconds(frame.time - first_);
  return *start_ + std::chrono::duration_cast<Clock::duration>(since_first / speed_);
}

void RealtimeSource::wait_until(Clock::time_point time, const std::function<bool()>& stopping) const {
  constexpr std::chrono::milliseconds kPoll{50};  // a gap in the recording must not hold up Ctrl-C
  while (!stopping() && Clock::now() < time) std::this_thread::sleep_until(std::min(time, Clock::now() + kPoll));
}

}  // namespace plumbline::app
