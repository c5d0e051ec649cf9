#include "cli/console.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "plumbline/error.h"

namespace plumbline::app {
namespace {

// The first error of stdout: a later successful flush must not hide it.
int stdout_error = 0;

void note_error(bool failed) {
  if (failed && stdout_error == 0) stdout_error = errno == 0 ? EIO : errno;
}

}  // namespace

void say(std::string_view line) {
  errno = 0;
  note_error(std::fwrite(line.data(), 1, line.size(), stdout) != line.size() || std::fputc('\n', stdout) == EOF ||
             std::fflush(stdout) != 0);
}

void complain(std::string_view message) {
  const std::string text = fmt::format("plumbline: error: {}\n", message);
  std::fwrite(text.data(), 1, text.size(), stderr);
}

void warn(std::string_view message) {
  const std::string text = fmt::format("plumbline: warning: {}\n", message);
  std::fwrite(text.data(), 1, text.size(), stderr);
}

void put_status(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

void flush_output() {
  errno = 0;
  note_error(std::fflush(stdout) != 0);
  if (stdout_error != 0 && stdout_error != EPIPE)
    throw Error(fmt::format("the output could not be written ({})", std::strerror(stdout_error)), "standard output",
                "Make room, or send it somewhere else.");
}

int terminal_width() {
  if (isatty(STDERR_FILENO) == 0) return 0;
  winsize size{};
  constexpr int kUsual = 80;
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : kUsual;
}

std::string length_text(double metres) {
  return metres < 1 ? fmt::format("{:.1f}\u00a0mm", 1e3 * metres) : fmt::format("{:.2f}\u00a0m", metres);
}

std::string duration_text(double seconds) {
  const auto total = std::isfinite(seconds) && seconds > 0 ? static_cast<long long>(std::llround(seconds)) : 0LL;
  const long long hours = total / 3600, minutes = total / 60 % 60;
  if (hours > 0) return fmt::format("{}:{:02}:{:02}", hours, minutes, total % 60);
  return fmt::format("{}:{:02}", minutes, total % 60);
}

}  // namespace plumbline::app
