// How 7-Scenes names its files (Shotton et al., "Scene Coordinate Regression Forests", 2013).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "plumbline/time.h"

namespace plumbline {

/// One numbered file of a folder.
struct NumberedFile {
  long long number = 0;
  std::string path;
};

/// Files named `frame-<digits><suffix>`, by number.
std::vector<NumberedFile> seven_scenes_files(const std::string& folder, const std::string& suffix);

/// The time of frame k of a camera without stamps, at 30 frames a second.
constexpr Nanoseconds time_at_30_hz(long long k) { return (k * kNanosecondsPerSecond + 15) / 30; }

}  // namespace plumbline
