// Lines for people: results on stdout, complaints and progress on stderr.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>

namespace plumbline::app {

/// Prints a line to stdout. What stdout refuses is reported by `flush_output`.
void say(std::string_view line);

template <class... Args>
void say(fmt::format_string<Args...> format, Args&&... args) {
  say(std::string_view(fmt::format(format, std::forward<Args>(args)...)));
}

/// "plumbline: error: …" on stderr.
void complain(std::string_view message);

/// "plumbline: warning: …" on stderr: something is missing that the command can do without.
void warn(std::string_view message);

/// To stderr at once, without a new line: what redraws a line.
void put_status(std::string_view text);

/// Throws Error if something said could not be written (a full disk behind a redirection). A reader that closed its
/// end of a pipe has seen all that it wanted: no error.
void flush_output();

/// Columns of the terminal behind stderr, or 0 if it is not one.
int terminal_width();

/// "12.3 mm" or "1.23 m".
std::string length_text(double metres);

/// "1:02:03" or "2:03".
std::string duration_text(double seconds);

}  // namespace plumbline::app
