// What readers of tables with a heading and a stamp in front have in common.
#pragma once

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>
#include <vector>

#include "io/stamped_lines.h"
#include "io/text_file.h"

namespace plumbline {

inline std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

/// Names of columns between commas, or between blanks where there are none; as they stand there.
inline std::vector<std::string_view> split_heading(std::string_view head) {
  if (head.find(',') == std::string_view::npos) return split_fields(head);
  std::vector<std::string_view> names;
  for (std::string_view rest = head; !rest.empty();) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    names.push_back(trim(rest.substr(0, comma)));
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  return names;
}

inline std::string_view first_field(const TextLine& line) {
  const auto fields = split_fields(line.text, true);
  return fields.empty() ? std::string_view() : fields.front();
}

/// A heading is a line whose first field is a word.
inline bool is_heading(const TextLine& line) {
  const std::string_view first = first_field(line);
  return !first.empty() && (std::isalpha(static_cast<unsigned char>(first.front())) != 0 || first.front() == '"') &&
         !parse_double(first);
}

/// Whether the heading says so, or a stamp is a whole number too great for seconds.
inline bool has_nanoseconds(std::string_view head, const std::vector<TextLine>& lines) {
  constexpr std::size_t kDigits = 11;  // whole seconds of 317 years
  return head.find("[ns]") != std::string_view::npos ||
         std::any_of(lines.begin(), lines.end(), [](const TextLine& line) {
           const std::string_view stamp = first_field(line);
           return stamp.size() >= kDigits && parse_unsigned(stamp).has_value();
         });
}

/// A stamp in seconds, or in whole nanoseconds. Throws Error with file and line for anything else.
inline Nanoseconds parse_stamp(const TextFile& file, const TextLine& line, std::string_view text, bool nanoseconds,
                               const char* advice) {
  if (!nanoseconds) return stamp_of(file, line, text, advice);
  const auto time = parse_unsigned(text);
  if (!time) file.fail(line, fmt::format("'{}' is not a time in whole nanoseconds", text), advice);
  return *time;
}

}  // namespace plumbline
