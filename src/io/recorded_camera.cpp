#include "io/recorded_camera.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "io/text_file.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

constexpr const char* kMatrixAdvice = "write the matrix as three lines: fx 0 cx, 0 fy cy, 0 0 1";

/// Every number of the file; brackets count as blanks.
std::vector<double> numbers_of(const TextFile& file) {
  std::vector<double> numbers;
  for (const TextLine& line : file.lines()) {
    std::string text(line.text);
    for (char& c : text)
      if (c == '[' || c == ']' || c == '(' || c == ')' || c == ';') c = ' ';
    for (const std::string_view field : split_fields(text, true)) {
      const auto value = parse_double(field);
      if (!value || !std::isfinite(*value))
        file.fail(line, fmt::format("'{}' is not a finite number", field), kMatrixAdvice);
      numbers.push_back(*value);
    }
  }
  return numbers;
}

}  // namespace

std::optional<Pinhole> scaled_to(const Pinhole& camera, int width, int height) {
  if (camera.width <= 0 || camera.height <= 0) return std::nullopt;
  const double sx = static_cast<double>(width) / camera.width, sy = static_cast<double>(height) / camera.height;
  if (std::abs(sx / sy - 1) > 0.01) return std::nullopt;
  Pinhole scaled{static_cast<float>(camera.fx * sx),
                 static_cast<float>(camera.fy * sy),
                 static_cast<float>((camera.cx + 0.5) * sx - 0.5),
                 static_cast<float>((camera.cy + 0.5) * sy - 0.5),
                 width,
                 height};
  return scaled;
}

Pinhole read_matrix_file(const std::string& path) {
  const std::vector<double> m = numbers_of(TextFile(path));
  if (m.size() != 9 && m.size() != 16)
    throw Error(fmt::format("has {} numbers where the matrix has 9", m.size()), path, kMatrixAdvice);
  const std::size_t row = m.size() == 9 ? 3 : 4;
  const auto at = [&](std::size_t r, std::size_t c) { return m[r * row + c]; };
  if (std::abs(at(0, 1)) > 1e-6 || at(1, 0) != 0 || at(2, 0) != 0 || at(2, 1) != 0 || at(2, 2) != 1)
    throw Error("is not the matrix of a camera without skew", path, kMatrixAdvice);
  return {static_cast<float>(at(0, 0)),
          static_cast<float>(at(1, 1)),
          static_cast<float>(at(0, 2)),
          static_cast<float>(at(1, 2)),
          0,
          0};
}

}  // namespace plumbline
