// Values of options that are more than one word or number.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "plumbline/error.h"
#include "plumbline/se3.h"

namespace plumbline::app {

/// A mistake on the command line: exit code 2.
class UsageError : public Error {
 public:
  using Error::Error;
  explicit UsageError(const Error& error) : Error(error) {}
};

/// `count` finite numbers between commas or blanks. Throws UsageError that names the option and the `form` it takes.
std::vector<double> parse_numbers(std::string_view text, std::size_t count, const std::string& option,
                                  const std::string& form);

/// "tx ty tz qx qy qz qw", metres and a quaternion that need not be exactly unit.
SE3 parse_pose(std::string_view text, const std::string& option);

/// "640x480".
std::pair<int, int> parse_size(std::string_view text, const std::string& option);

/// The words of a command as a line that a shell takes.
std::string command_text(const std::vector<std::string>& words);

/// Runs `action`, whose Errors are then mistakes on the command line.
template <class Action>
auto as_usage(Action&& action) {
  try {
    return action();
  } catch (const UsageError&) {
    throw;
  } catch (const Error& error) {
    throw UsageError(error);
  }
}

}  // namespace plumbline::app
