#include "core/depth_distortion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"

namespace plumbline {
namespace {

/// Without branches, so that it becomes vector code: no reading is 1/0, and stays none.
void correct_row(float readings_per_metre, const float* errors, int width, std::uint16_t* row) {
  constexpr float kLargest = std::numeric_limits<std::uint16_t>::max();
  for (int x = 0; x < width; ++x) {
    const float inverse = readings_per_metre / static_cast<float>(row[x]) - errors[x];
    const float reading = readings_per_metre / inverse + 0.5f;
    row[x] = static_cast<std::uint16_t>(inverse > 0 && reading <= kLargest ? static_cast<int>(reading) : 0);
  }
}

}  // namespace

DepthDistortion::DepthDistortion(int width, int height)
    : width_(width), height_(height), step_(static_cast<double>(width - 1) / (kColumns - 1)) {
  rows_ = static_cast<int>(std::ceil((height - 1) / step_ - 1e-9)) + 1;
  values_.assign(static_cast<std::size_t>(kColumns) * static_cast<std::size_t>(rows_), 0);
}

double DepthDistortion::rms() const {
  double sum = 0;
  for (const double value : values_) sum += value * value;
  return values_.empty() ? 0 : std::sqrt(sum / static_cast<double>(values_.size()));
}

DepthDistortion::Nodes DepthDistortion::nodes(double x, double y) const {
  // The last node belongs to the cell before it.
  const double column = std::clamp(x / step_, 0.0, kColumns - 1 - 1e-9),
               row = std::clamp(y / step_, 0.0, rows_ - 1 - 1e-9);
  const double a = column - std::floor(column), b = row - std::floor(row);
  const std::size_t first = static_cast<std::size_t>(row) * kColumns + static_cast<std::size_t>(column);
  return {{first, first + 1, first + kColumns, first + kColumns + 1},
          {(1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b}};
}

double DepthDistortion::at(const Nodes& n) const {
  double sum = 0;
  for (std::size_t i = 0; i < 4; ++i) sum += n.share[i] * values_[n.index[i]];
  return sum;
}

std::string DepthDistortion::describe() const {
  constexpr double kDepth = 2;  // metres: dz = z² d(1/z)
  return fmt::format("a distortion of the depth of {:.1f} cm rms at {} m", 100 * kDepth * kDepth * rms(), kDepth);
}

void DepthDistortion::check_size(int width, int height) const {
  if (width == width_ && height == height_) return;
  throw Error(fmt::format("it is of images of {}x{}, these are {}x{}", width_, height_, width, height),
              "depth calibration", "Calibrate the depth with a recording of this size.");
}

void DepthDistortion::correct(double readings_per_metre, DepthImage* depth) const {
  if (empty()) return;
  check_size(depth->width, depth->height);
  std::vector<float> errors(static_cast<std::size_t>(width_));
  for (int y = 0; y < height_; ++y) {
    fill_row(y, &errors);
    correct_row(static_cast<float>(readings_per_metre), errors.data(), width_, depth->row(y));
  }
}

void DepthDistortion::fill_row(int y, std::vector<float>* errors) const {
  for (int column = 0; column + 1 < kColumns; ++column) {
    const double left = at(column * step_, y), right = at((column + 1) * step_, y);
    const bool is_last = column + 2 == kColumns;
    const auto first = static_cast<int>(std::ceil(column * step_)),
               end = is_last ? width_ : static_cast<int>(std::floor((column + 1) * step_)) + 1;
    for (int x = first; x < end; ++x)
      (*errors)[static_cast<std::size_t>(x)] = static_cast<float>(left + (x / step_ - column) * (right - left));
  }
}

}  // namespace plumbline
