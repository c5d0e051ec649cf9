// What the readers of lines with a time stamp have in common.
#pragma once

#include <fmt/format.h>

#include <algorithm>
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

/// A stamp in seconds. Throws Error with file and line for anything else.
inline Nanoseconds stamp_of(const TextFile& file, const TextLine& line, std::string_view text, const char* advice) {
  const auto time = parse_seconds(text);
  if (!time) file.fail(line, fmt::format("'{}' is not a time in seconds", text), advice);
  return *time;
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
