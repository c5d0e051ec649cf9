// How far a run is: a bar on a terminal, a line now and then otherwise.
#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <utility>

namespace plumbline::app {

struct ProgressState {
  int done = 0, total = 0;  ///< frames, or what else is counted; negative: nobody knows how many
  int tracked = 0, lost = 0;
  double seconds = 0;     ///< since the first frame was asked for
  std::string more = {};  ///< after the counts
};

/// What is counted, what became of it for better or worse, and how many lie between two lines where there is no
/// terminal.
struct ProgressWords {
  std::string unit = "frame", good = "tracked", bad = "lost";
  int interval = 50;
};

/// One line of at most `width` columns: what matters most comes first, the bar takes what is left.
std::string progress_line(const ProgressState& state, int width, const ProgressWords& words = {});

/// Draws on stderr. Nothing is drawn before the first `update`, and nothing of the bar stays after the destructor.
class Progress {
 public:
  /// `quiet`: draws nothing.
  Progress(int total, bool quiet, ProgressWords words = {});
  ~Progress() { erase(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void update(int done, int tracked, int lost);
  /// Stands after the counts from now on.
  void add_text(std::string text) { more_ = std::move(text); }
  /// A line that stays above the bar.
  void note(std::string_view line);
  double seconds() const;

 private:
  void erase();
  void draw();

  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now(), drawn_{};
  ProgressState state_;
  std::string more_;
  ProgressWords words_;
  bool quiet_, terminal_, visible_ = false;
};

}  // namespace plumbline::app
