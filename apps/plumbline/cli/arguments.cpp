#include "cli/arguments.h"

#include <charconv>
#include <cmath>

namespace plumbline::app {
namespace {

/// In single quotes; one within them ends the text and begins it again.
std::string quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

constexpr int kMaxImageSide = 16384;

std::vector<std::string_view> split(std::string_view text) {
  constexpr std::string_view kSeparators = ", \t";
  std::vector<std::string_view> words;
  for (std::size_t begin = text.find_first_not_of(kSeparators); begin != std::string_view::npos;) {
    const std::size_t end = text.find_first_of(kSeparators, begin);
    words.push_back(text.substr(begin, end - begin));
    begin = text.find_first_not_of(kSeparators, end);
  }
  return words;
}

template <class T>
bool parse_whole(std::string_view word, T* value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), *value);
  return error == std::errc() && end == word.data() + word.size();
}

}  // namespace

std::vector<double> parse_numbers(std::string_view text, std::size_t count, const std::string& option,
                                  const std::string& form) {
  const std::vector<std::string_view> words = split(text);
  if (words.size() != count)
    throw UsageError("takes " + std::to_string(count) + " numbers, not " + std::to_string(words.size()), option,
                     "Write " + form + ".");
  std::vector<double> numbers(count);
  for (std::size_t i = 0; i < count; ++i)
    if (!parse_whole(words[i], &numbers[i]) || !std::isfinite(numbers[i]))
      throw UsageError("'" + std::string(words[i]) + "' is not a finite number", option, "Write " + form + ".");
  return numbers;
}

SE3 parse_pose(std::string_view text, const std::string& option) {
  const std::vector<double> n = parse_numbers(text, 7, option, "\"tx ty tz qx qy qz qw\"");
  const Eigen::Quaterniond rotation(n[6], n[3], n[4], n[5]);
  if (std::abs(rotation.norm() - 1) > 0.01)
    throw UsageError("the quaternion is not of unit length", option,
                     "Its order is x y z w; no rotation is \"0 0 0 1\".");
  return {rotation, {n[0], n[1], n[2]}};
}

std::pair<int, int> parse_size(std::string_view text, const std::string& option) {
  const std::size_t x = text.find('x');
  int width = 0, height = 0;
  if (x == std::string_view::npos || !parse_whole(text.substr(0, x), &width) ||
      !parse_whole(text.substr(x + 1), &height) || width < 1 || height < 1 || width > kMaxImageSide ||
      height > kMaxImageSide)
    throw UsageError("'" + std::string(text) + "' is not a size", option, "Write WIDTHxHEIGHT, for example 640x480.");
  return {width, height};
}

std::string command_text(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) {
    const bool plain = !word.empty() && word.find_first_of(" \t\"'\\$`*?[](){};&|<>#~") == std::string::npos;
    line += (line.empty() ? "" : " ") + (plain ? word : quoted(word));
  }
  return line;
}

}  // namespace plumbline::app
