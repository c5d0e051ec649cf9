#include "plumbline/depth_distortion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "plumbline/error.h"
#include "plumbline/image.h"

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

/// Four nodes of a line of them and their shares in what lies between.
struct Line {
  std::size_t first;
  std::array<double, 4> share;
};

/// `position` in nodes, of at least four; at either end the line goes on as a parabola (Keys 1981).
Line line(double position, int nodes) {
  const int cell = std::clamp(static_cast<int>(position), 0, nodes - 2);
  const double t = std::clamp(position - cell, 0.0, 1.0);
  const std::array<double, 4> w = {((1 - 0.5 * t) * t - 0.5) * t, (1.5 * t - 2.5) * t * t + 1,
                                   ((2 - 1.5 * t) * t + 0.5) * t, (0.5 * t - 0.5) * t * t};
  if (cell == 0) return {0, {w[1] + 3 * w[0], w[2] - 3 * w[0], w[3] + w[0], 0}};
  if (cell == nodes - 2)
    return {static_cast<std::size_t>(nodes - 4), {0, w[0] + w[3], w[1] - 3 * w[3], w[2] + 3 * w[3]}};
  return {static_cast<std::size_t>(cell - 1), w};
}

}  // namespace

DepthDistortion::DepthDistortion(int width, int height)
    : width_(width), height_(height), step_(static_cast<double>(width - 1) / (kColumns - 1)) {
  rows_ = std::max(4, static_cast<int>(std::ceil((height - 1) / step_ - 1e-9)) + 1);
  values_.assign(static_cast<std::size_t>(kColumns) * static_cast<std::size_t>(rows_), 0);
}

double DepthDistortion::rms() const {
  double sum = 0;
  for (const double value : values_) sum += value * value;
  return values_.empty() ? 0 : std::sqrt(sum / static_cast<double>(values_.size()));
}

DepthDistortion::Nodes DepthDistortion::nodes(double x, double y) const {
  const Line across = line(x / step_, kColumns), down = line(y / step_, rows_);
  Nodes n{down.first * kColumns + across.first, {}};
  for (std::size_t r = 0; r < 4; ++r)
    for (std::size_t c = 0; c < 4; ++c) n.share[4 * r + c] = down.share[r] * across.share[c];
  return n;
}

double DepthDistortion::at(const Nodes& n) const {
  double sum = 0;
  for (std::size_t i = 0; i < n.share.size(); ++i) sum += n.share[i] * values_[n.index(i)];
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
  std::vector<Line> across;
  across.reserve(static_cast<std::size_t>(width_));
  for (int x = 0; x < width_; ++x) across.push_back(line(x / step_, kColumns));
  std::vector<float> errors(across.size());
  for (int y = 0; y < height_; ++y) {
    const Line down = line(y / step_, rows_);
    std::array<double, kColumns> nodes{};  // where their columns meet the row
    for (std::size_t r = 0; r < 4; ++r)
      for (std::size_t c = 0; c < kColumns; ++c) nodes[c] += down.share[r] * values_[(down.first + r) * kColumns + c];
    for (std::size_t x = 0; x < across.size(); ++x) {
      const double* four = &nodes[across[x].first];
      const std::array<double, 4>& share = across[x].share;
      errors[x] = static_cast<float>(share[0] * four[0] + share[1] * four[1] + share[2] * four[2] + share[3] * four[3]);
    }
    correct_row(static_cast<float>(readings_per_metre), errors.data(), width_, depth->row(y));
  }
}

}  // namespace plumbline
