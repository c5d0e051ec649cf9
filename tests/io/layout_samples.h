// Small images for folders as recorders leave them.
#pragma once

#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>

#include "io/images/png.h"
#include "plumbline/sequence.h"
#include "support/temp_folder.h"

namespace plumbline {

namespace fs = std::filesystem;

constexpr int kWidth = 64, kHeight = 48;

/// A slope: readings from `near` to three times as much.
inline void write_slope(const fs::path& path, int near, int width = kWidth, int height = kHeight) {
  DepthImage depth(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) depth.at(x, y) = static_cast<std::uint16_t>(near + 2 * near * x / width);
  fs::create_directories(path.parent_path());
  write_depth_png(path.string(), depth);
}

inline void write_color(const fs::path& path, std::uint8_t value, int width = kWidth, int height = kHeight) {
  ColorImage color(width, height, 3);
  std::fill(color.pixels.begin(), color.pixels.end(), value);
  fs::create_directories(path.parent_path());
  write_color_png(path.string(), color);
}

inline SequenceOptions small_camera() {
  SequenceOptions options;
  options.intrinsics = Pinhole{50, 50, 31.5f, 23.5f, 0, 0};
  return options;
}

inline std::unique_ptr<Sequence> open_folder(const test::TempFolder& folder, const SequenceOptions& options = {}) {
  return open_sequence(folder.path().string(), options);
}

inline auto warns_of(const std::string& what, const std::string& what_to_do) {
  return testing::Contains(testing::AllOf(testing::Field(&Warning::what, testing::HasSubstr(what)),
                                          testing::Field(&Warning::what_to_do, testing::HasSubstr(what_to_do))));
}

}  // namespace plumbline
