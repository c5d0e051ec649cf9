#include "view/picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace plumbline::app {
namespace {

constexpr double kNearest = 0.4, kFarthest = 5;  ///< metres, the ends of the colours

template <class T>
Image<T> thinned(const Image<T>& image, int step) {
  Image<T> small(image.width / step, image.height / step, image.channels);
  const int n = image.channels;
  for (int y = 0; y < small.height; ++y) {
    const T* from = image.row(y * step);
    T* to = small.row(y);
    for (int x = 0; x < small.width; ++x)
      for (int c = 0; c < n; ++c) to[n * x + c] = from[n * x * step + c];
  }
  return small;
}

/// From red over yellow and green to blue; `share` 0 … 1.
std::array<std::uint8_t, 3> spectrum(double share) {
  const auto channel = [](double x) { return static_cast<std::uint8_t>(std::lround(235 * std::clamp(x, 0.0, 1.0))); };
  return {channel(1.5 - std::abs(4 * share - 0.6)), channel(1.5 - std::abs(4 * share - 1.9)),
          channel(1.5 - std::abs(4 * share - 3.2))};
}

/// Mean square of the differences between pixels that lie so far apart. An edge that is smeared has the same
/// differences in sum, but smaller squares.
double variation(const ColorImage& image, int dx, int dy) {
  const int n = image.channels, green = n > 1 ? 1 : 0;
  std::int64_t sum = 0;
  for (int y = 0; y + dy < image.height; ++y) {
    const std::uint8_t *here = image.row(y) + green, *there = image.row(y + dy) + dx * n + green;
    for (int x = 0; x + dx < image.width; ++x) {
      const int difference = there[x * n] - here[x * n];
      sum += difference * difference;
    }
  }
  return static_cast<double>(sum) / std::max(1, (image.width - dx) * (image.height - dy));
}

/// A colour for each reading: computed once a picture, by 256 steps of inverse depth, so that what is near shows more.
std::array<std::array<std::uint8_t, 3>, 256> palette() {
  std::array<std::array<std::uint8_t, 3>, 256> colors{};
  for (std::size_t i = 0; i < colors.size(); ++i) colors[i] = spectrum(static_cast<double>(i) / 255);
  return colors;
}

}  // namespace

SmallFrame small_frame(const DepthImage& depth, const ColorImage& color, double depth_scale, int max_width) {
  const int step = std::max(1, (depth.width + max_width - 1) / max_width);
  SmallFrame small{thinned(depth, step), {}, depth_scale};
  if (!color.empty()) small.color = thinned(color, step);
  return small;
}

ColorImage depth_colors(const DepthImage& depth, double depth_scale) {
  static const auto kPalette = palette();
  ColorImage colors(depth.width, depth.height, 3);
  for (std::size_t i = 0; i < depth.pixels.size(); ++i) {
    if (depth.pixels[i] == 0) continue;
    const double metres = depth.pixels[i] / depth_scale;
    const double share = (1 / kNearest - 1 / metres) / (1 / kNearest - 1 / kFarthest);
    const auto& color = kPalette[static_cast<std::size_t>(255 * std::clamp(share, 0.0, 1.0))];
    std::copy(color.begin(), color.end(), &colors.pixels[3 * i]);
  }
  return colors;
}

DepthStatistics depth_statistics(const DepthImage& depth, double depth_scale) {
  constexpr std::size_t kEvery = 97;  // prime: no column is favoured
  std::vector<std::uint16_t> readings;
  std::size_t pixels = 0;
  for (std::size_t i = 0; i < depth.pixels.size(); i += kEvery, ++pixels)
    if (depth.pixels[i] > 0) readings.push_back(depth.pixels[i]);
  if (readings.empty()) return {};
  const auto middle = readings.begin() + static_cast<std::ptrdiff_t>(readings.size() / 2);
  std::nth_element(readings.begin(), middle, readings.end());
  return {static_cast<double>(readings.size()) / static_cast<double>(pixels), *middle / depth_scale};
}

double sharpness(const ColorImage& color) {
  constexpr int kFar = 4;
  constexpr double kNoise = 4;  // square grey levels: where there is no more, nothing is there to be sharp
  const auto along = [&](int dx, int dy) {
    return variation(color, dx, dy) / (variation(color, kFar * dx, kFar * dy) + kNoise);
  };
  return std::min(along(1, 0), along(0, 1));
}

}  // namespace plumbline::app
