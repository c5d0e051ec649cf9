#include "core/undistort.h"

#include <algorithm>
#include <cmath>

namespace plumbline {
namespace {

constexpr int kMaxSpreadDivisor = 50;  // neighbours within 2 % of the depth belong to one surface

/// std::lround is a call into the library, several times as slow as the whole of a pixel.
int round_positive(float value) { return static_cast<int>(value + 0.5f); }  // NOLINT(bugprone-incorrect-roundings)

/// The reading at a position between four pixels. Written without branches: at a scene's edges they would be guessed
/// wrong again and again, and this runs for every pixel of every frame.
std::uint16_t sample_depth(const std::uint16_t* top, const std::uint16_t* bottom, float ax, float ay) {
  const int a = top[0], b = top[1], c = bottom[0], d = bottom[1];
  const int low = std::min(std::min(a, b), std::min(c, d));
  const int high = std::max(std::max(a, b), std::max(c, d));
  const float upper = static_cast<float>(a) + ax * static_cast<float>(b - a);
  const float lower = static_cast<float>(c) + ax * static_cast<float>(d - c);
  const int between = round_positive(upper + ay * (lower - upper));
  const int left = ay < 0.5f ? a : c, right = ay < 0.5f ? b : d;
  const int nearest = ax < 0.5f ? left : right;
  const bool one_surface = (low > 0) & ((high - low) * kMaxSpreadDivisor <= low);
  return static_cast<std::uint16_t>(one_surface ? between : nearest);
}

/// Bilinear between 8-bit values with weights of 8 bits, which is as fine as the result.
std::uint8_t sample_color(int a, int b, int c, int d, int ax, int ay) {
  const int upper = a * (256 - ax) + b * ax;
  const int lower = c * (256 - ax) + d * ax;
  return static_cast<std::uint8_t>((upper * (256 - ay) + lower * ay + (1 << 15)) >> 16);
}

}  // namespace

Undistorter::Source Undistorter::source_at(float x, float y, int width, int height) {
  const auto right = static_cast<float>(width) - 0.5f, bottom = static_cast<float>(height) - 0.5f;
  if (!(x >= -0.5f && y >= -0.5f && x < right && y < bottom)) return {-1, 0, 0};
  const int left = std::clamp(static_cast<int>(std::floor(x)), 0, width - 2);
  const int top = std::clamp(static_cast<int>(std::floor(y)), 0, height - 2);
  return {top * width + left, std::clamp(x - static_cast<float>(left), 0.0f, 1.0f),
          std::clamp(y - static_cast<float>(top), 0.0f, 1.0f)};
}

Undistorter::Undistorter(const Pinhole& camera, const Distortion& distortion)
    : width_(camera.width), height_(camera.height) {
  if (distortion.is_zero() || width_ < 2 || height_ < 2) return;
  source_.reserve(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  for (int v = 0; v < height_; ++v) {
    for (int u = 0; u < width_; ++u) {
      double x = 0, y = 0;
      distortion.apply((u - static_cast<double>(camera.cx)) / camera.fx,
                       (v - static_cast<double>(camera.cy)) / camera.fy, &x, &y);
      source_.push_back(source_at(static_cast<float>(x * camera.fx + camera.cx),
                                  static_cast<float>(y * camera.fy + camera.cy), width_, height_));
    }
  }
}

void Undistorter::apply(DepthImage& depth) const {
  if (is_identity()) return;
  DepthImage result(width_, height_);
  for (std::size_t i = 0; i < source_.size(); ++i) {
    const Source source = source_[i];
    if (source.cell < 0) continue;
    const std::uint16_t* top = depth.pixels.data() + source.cell;
    result.pixels[i] = sample_depth(top, top + width_, source.ax, source.ay);
  }
  depth = std::move(result);
}

void Undistorter::apply(ColorImage& color) const {
  if (is_identity()) return;
  ColorImage result(width_, height_, color.channels);
  const int channels = color.channels;
  for (std::size_t i = 0; i < source_.size(); ++i) {
    const Source source = source_[i];
    if (source.cell < 0) continue;
    const std::uint8_t* top = color.pixels.data() + static_cast<std::ptrdiff_t>(source.cell) * channels;
    const std::uint8_t* bottom = top + static_cast<std::ptrdiff_t>(width_) * channels;
    std::uint8_t* out = result.pixels.data() + i * static_cast<std::size_t>(channels);
    const int ax = round_positive(source.ax * 256), ay = round_positive(source.ay * 256);
    for (int c = 0; c < channels; ++c)
      out[c] = sample_color(top[c], top[c + channels], bottom[c], bottom[c + channels], ax, ay);
  }
  color = std::move(result);
}

}  // namespace plumbline
