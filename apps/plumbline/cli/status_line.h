// One line on a terminal that is redrawn as long as something goes on; lines now and then otherwise.
#pragma once

#include <chrono>
#include <string_view>

namespace plumbline::app {

/// Draws on stderr. Nothing of the line stays after the destructor.
class StatusLine {
 public:
  /// `quiet`: draws nothing.
  explicit StatusLine(bool quiet);
  ~StatusLine() { erase(); }
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  /// Whether an update would be drawn now: ten times a second on a terminal, else every five seconds.
  bool is_due() const;
  void update(std::string_view text);
  /// A line that stays above.
  void note(std::string_view line);

 private:
  void erase();

  using Clock = std::chrono::steady_clock;
  Clock::time_point drawn_{};
  bool quiet_, terminal_, visible_ = false;
};

}  // namespace plumbline::app
