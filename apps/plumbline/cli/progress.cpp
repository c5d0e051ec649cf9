#include "cli/progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "cli/console.h"

namespace plumbline::app {
namespace {

constexpr int kPlainWidth = 100;
constexpr std::chrono::milliseconds kRedrawInterval{100};
constexpr int kMinBar = 10, kMaxBar = 40;  // columns

std::string bar(const ProgressState& state, int columns) {
  const double fraction = state.total > 0 ? std::clamp(static_cast<double>(state.done) / state.total, 0.0, 1.0) : 0.0;
  const auto full = static_cast<std::size_t>(fraction * columns);
  return "[" + std::string(full, '#') + std::string(static_cast<std::size_t>(columns) - full, '-') + "] ";
}

/// Counts, speed and time to go, as many of them as fit in `width` columns.
std::string status_text(const ProgressState& state, int width, const ProgressWords& words) {
  const double rate = state.seconds > 0 ? state.done / state.seconds : 0;
  const bool endless = state.total<0, slow = rate> 0 && rate < 0.5;
  const std::array<std::string, 5> parts = {
      endless ? fmt::format("{}", state.done) : fmt::format("{}/{}", state.done, state.total),
      fmt::format("  {} {}, {} {}", state.tracked, words.good, state.lost, words.bad), state.more,
      slow ? fmt::format("  {:.1f} {}s/min", 60 * rate, words.unit) : fmt::format("  {:.1f} {}s/s", rate, words.unit),
      rate > 0 && !endless ? fmt::format("  ETA {}", duration_text((state.total - state.done) / rate)) : std::string()};
  std::string line;
  for (const std::string& part : parts) {
    if (static_cast<int>(line.size() + part.size()) > width) break;
    line += part;
  }
  return line;
}

}  // namespace

std::string progress_line(const ProgressState& state, int width, const ProgressWords& words) {
  const std::string status = status_text(state, width, words);
  const int room = width - static_cast<int>(status.size()) - 3;  // brackets and a blank
  return room < kMinBar || state.total < 0 ? status : bar(state, std::min(room, kMaxBar)) + status;
}

Progress::Progress(int total, bool quiet, ProgressWords words)
    : words_(std::move(words)), quiet_(quiet), terminal_(terminal_width() > 0) {
  state_.total = total;
}

double Progress::seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

void Progress::update(int done, int tracked, int lost) {
  state_ = {done, state_.total, tracked, lost, seconds(), more_};
  if (quiet_) return;
  if (!terminal_) {
    if (done > 0 && (done % words_.interval == 0 || done == state_.total))
      put_status(fmt::format("{} {}\n", words_.unit, status_text(state_, kPlainWidth, words_)));
    return;
  }
  const Clock::time_point now = Clock::now();
  if (words_.interval > 1 && now - drawn_ < kRedrawInterval) return;  // of what is rare, each counts
  drawn_ = now;
  draw();
}

void Progress::note(std::string_view line) {
  if (quiet_) return;
  erase();
  put_status(fmt::format("{}\n", line));
}

void Progress::draw() {
  // The last column stays free: some terminals begin a new line when it is filled.
  put_status("\r" + progress_line(state_, std::max(1, terminal_width() - 1), words_) + "\x1b[K");
  visible_ = true;
}

void Progress::erase() {
  if (visible_) put_status("\r\x1b[K");
  visible_ = false;
}

}  // namespace plumbline::app
