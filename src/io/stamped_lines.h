// What the readers of lines with a time stamp have in common.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "io/text_file.h"
#include "plumbline/time.h"

namespace plumbline {

/// By how much the length of a quaternion in a file may differ from 1: rounding to two digits does as much.
constexpr double kUnitTolerance = 1e-2;

inline void add_note(std::vector<std::string>* notes, const std::string& note) {
  if (notes != nullptr) notes->push_back(note);
}

inline void note_half_written(std::vector<std::string>* notes, const TextLine& line) {
  add_note(notes, fmt::format("the last line ({}) is half-written and was left out", line.number));
}

/// By how many digits the point of a stamp must move to the left for seconds, by the stamp's size: seconds since 1970
/// have ten digits before the point. 0, 3, 6 or 9.
inline int decimals_by_size(std::string_view stamp) {
  const double value = std::abs(parse_double(stamp).value_or(0));
  return value > 1e17 ? 9 : value > 1e14 ? 6 : value > 1e11 ? 3 : 0;
}

/// The same by the median interval of a camera's frames: more than five seconds is no interval of a recording.
inline int decimals_by_interval(std::vector<double> stamps) {
  constexpr double kMinInterval = 1.0 / 500, kMaxInterval = 5;
  for (std::size_t i = stamps.size(); i-- > 1;) stamps[i] -= stamps[i - 1];
  if (stamps.size() < 4) return 0;
  const auto middle = stamps.begin() + static_cast<std::ptrdiff_t>(stamps.size() / 2);
  std::nth_element(stamps.begin() + 1, middle, stamps.end());
  if (*middle <= kMaxInterval) return 0;
  for (const int decimals : {3, 6, 9})
    if (const double seconds = *middle * std::pow(10, -decimals); seconds >= kMinInterval && seconds <= kMaxInterval)
      return decimals;
  return 0;
}

inline const char* unit_of_decimals(int decimals) {
  return decimals == 9 ? "nanoseconds" : decimals == 6 ? "microseconds" : decimals == 3 ? "milliseconds" : "seconds";
}

/// A stamp whose point is `decimals` digits too far to the right for seconds. Throws Error with file and line for
/// anything else.
inline Nanoseconds stamp_of(const TextFile& file, const TextLine& line, std::string_view text, const char* advice,
                            int decimals = 0) {
  if (const auto whole = parse_unsigned(text); whole && decimals == 9) return *whole;
  if (decimals == 0) {
    if (const auto time = parse_seconds(text)) return *time;
    file.fail(line, fmt::format("'{}' is not a time in seconds", text), advice);
  }
  const auto value = parse_double(text);
  if (!value || !(std::abs(*value) * std::pow(10, -decimals) < 9e9))
    file.fail(line, fmt::format("'{}' is not a time", text), advice);
  return from_seconds(*value * std::pow(10, -decimals));
}

/// Orders `items` (`noun` in the notes) by their member `time`; of those with the same stamp the first is kept.
template <class Stamped>
void sort_and_thin(std::vector<Stamped>* items, const char* noun, std::vector<std::string>* notes) {
  const auto by_time = [](const Stamped& a, const Stamped& b) { return a.time < b.time; };
  if (!std::is_sorted(items->begin(), items->end(), by_time)) {
    std::stable_sort(items->begin(), items->end(), by_time);
    add_note(notes, fmt::format("the {} were not in order of time and have been sorted", noun));
  }
  const std::size_t before = items->size();
  const auto same_time = [](const Stamped& a, const Stamped& b) { return a.time == b.time; };
  items->erase(std::unique(items->begin(), items->end(), same_time), items->end());
  if (const std::size_t dropped = before - items->size(); dropped > 0)
    add_note(notes, fmt::format("{} {} with the stamp of an earlier one were left out", dropped, noun));
}

}  // namespace plumbline
