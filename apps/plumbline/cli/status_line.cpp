#include "cli/status_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <string>

#include "cli/console.h"

namespace plumbline::app {
namespace {

constexpr std::chrono::milliseconds kRedraw{100}, kPlain{5000};

}  // namespace

StatusLine::StatusLine(bool quiet) : quiet_(quiet), terminal_(terminal_width() > 0) {}

bool StatusLine::is_due() const { return !quiet_ && Clock::now() - drawn_ >= (terminal_ ? kRedraw : kPlain); }

void StatusLine::update(std::string_view text) {
  if (!is_due()) return;
  drawn_ = Clock::now();
  if (!terminal_) return put_status(fmt::format("{}\n", text));
  // The last column stays free: some terminals begin a new line when it is filled.
  put_status(fmt::format("\r{}\x1b[K", text.substr(0, static_cast<std::size_t>(std::max(1, terminal_width() - 1)))));
  visible_ = true;
}

void StatusLine::note(std::string_view line) {
  if (quiet_) return;
  erase();
  put_status(fmt::format("{}\n", line));
}

void StatusLine::erase() {
  if (visible_) put_status("\r\x1b[K");
  visible_ = false;
}

}  // namespace plumbline::app
