#include "io/registration.h"

#include <algorithm>
#include <cmath>

namespace plumbline {
namespace {

/// Bilinear between the four pixels around a position that lies within the image.
void sample(const ColorImage& image, double u, double v, std::uint8_t* out) {
  const int left = std::clamp(static_cast<int>(std::floor(u)), 0, image.width - 2);
  const int top = std::clamp(static_cast<int>(std::floor(v)), 0, image.height - 2);
  const double ax = std::clamp(u - left, 0.0, 1.0), ay = std::clamp(v - top, 0.0, 1.0);
  const int channels = image.channels;
  const std::uint8_t* a = image.pixels.data() + (static_cast<std::ptrdiff_t>(top) * image.width + left) * channels;
  const std::uint8_t* b = a + static_cast<std::ptrdiff_t>(image.width) * channels;
  for (int c = 0; c < channels; ++c) {
    const double upper = a[c] + ax * (a[c + channels] - a[c]), lower = b[c] + ax * (b[c + channels] - b[c]);
    out[c] = static_cast<std::uint8_t>(upper + ay * (lower - upper) + 0.5);
  }
}

}  // namespace

ColorImage ColorRegistration::apply(const DepthImage& readings, double depth_scale, const ColorImage& image) const {
  ColorImage result(readings.width, readings.height, image.channels);
  if (image.width < 2 || image.height < 2) return result;
  const Eigen::Matrix3d rotation = color_from_depth.rotation();
  const Eigen::Vector3d translation = color_from_depth.translation();
  for (int y = 0; y < readings.height; ++y) {
    const Eigen::Vector3d row = rotation.col(1) * ((y - static_cast<double>(depth.cy)) / depth.fy) + rotation.col(2);
    for (int x = 0; x < readings.width; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * readings.width + x;
      if (readings.pixels[i] == 0) continue;
      const Eigen::Vector3d ray = rotation.col(0) * ((x - static_cast<double>(depth.cx)) / depth.fx) + row;
      const Eigen::Vector3d point = ray * (readings.pixels[i] / depth_scale) + translation;
      if (point.z() <= 0) continue;
      double u = 0, v = 0;
      color_distortion.apply(point.x() / point.z(), point.y() / point.z(), &u, &v);
      u = u * color.fx + color.cx;
      v = v * color.fy + color.cy;
      if (!(u >= -0.5 && v >= -0.5 && u < image.width - 0.5 && v < image.height - 0.5)) continue;
      sample(image, u, v, result.pixels.data() + i * static_cast<std::size_t>(image.channels));
    }
  }
  return result;
}

DepthImage seen_through(const Pinhole& from, const Pinhole& to, const DepthImage& readings) {
  const auto nearest = [](float position) { return static_cast<int>(std::lround(position)); };
  DepthImage result(readings.width, readings.height);
  for (int y = 0; y < readings.height; ++y) {
    const int v = nearest((static_cast<float>(y) - to.cy) / to.fy * from.fy + from.cy);
    if (v < 0 || v >= readings.height) continue;
    for (int x = 0; x < readings.width; ++x) {
      const int u = nearest((static_cast<float>(x) - to.cx) / to.fx * from.fx + from.cx);
      if (u >= 0 && u < readings.width) result.at(x, y) = readings.at(u, v);
    }
  }
  return result;
}

}  // namespace plumbline
