#include "io/images/raw_color.h"

#include <algorithm>
#include <cmath>

namespace plumbline {
namespace {

std::uint8_t to_byte(double value) { return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0))); }

/// ITU-R BT.601, as OpenCV and V4L take it.
void to_rgb(double luma, double u, double v, std::uint8_t* rgb) {
  const double y = 255.0 / 219 * (luma - 16), cb = u - 128, cr = v - 128;
  rgb[0] = to_byte(y + 1.596 * cr);
  rgb[1] = to_byte(y - 0.392 * cb - 0.813 * cr);
  rgb[2] = to_byte(y + 2.017 * cb);
}

}  // namespace

std::optional<YuvOrder> yuv_order(std::string_view encoding) {
  if (encoding == "yuv422" || encoding == "uyvy") return YuvOrder{1, 3, 0, 2};
  if (encoding == "yuv422_yuy2" || encoding == "yuyv" || encoding == "yuy2") return YuvOrder{0, 2, 1, 3};
  return std::nullopt;
}

ColorImage decode_yuv(const std::uint8_t* bytes, std::size_t step, int width, int height, const YuvOrder& order) {
  ColorImage color(width, height, 3);
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* in = bytes + static_cast<std::size_t>(y) * step;
    for (int x = 0; x + 1 < width; x += 2, in += 4) {
      to_rgb(in[order.first], in[order.u], in[order.v], &color.at(x, y));
      to_rgb(in[order.second], in[order.u], in[order.v], &color.at(x + 1, y));
    }
  }
  return color;
}

std::optional<BayerOrder> bayer_order(std::string_view encoding) {
  if (encoding == "bayer_rggb8") return BayerOrder{0, 0};
  if (encoding == "bayer_grbg8") return BayerOrder{1, 0};
  if (encoding == "bayer_gbrg8") return BayerOrder{0, 1};
  if (encoding == "bayer_bggr8") return BayerOrder{1, 1};
  return std::nullopt;
}

ColorImage decode_bayer(const std::uint8_t* bytes, std::size_t step, int width, int height, const BayerOrder& order) {
  // Channels of the pixels of even and odd columns and rows.
  const auto channel = [&](int x, int y) {
    const bool red_column = (x & 1) == order.red_x, red_row = (y & 1) == order.red_y;
    return red_column && red_row ? 0 : red_column == red_row ? 2 : 1;
  };
  ColorImage color(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      std::array<int, 3> sum{}, count{};
      for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height - 1); ++v)
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width - 1); ++u) {
          const auto c = static_cast<std::size_t>(channel(u, v));
          const bool itself = u == x && v == y, same = channel(x, y) == static_cast<int>(c);
          if (same && !itself) continue;
          sum[c] += bytes[static_cast<std::size_t>(v) * step + static_cast<std::size_t>(u)];
          ++count[c];
        }
      for (std::size_t c = 0; c < 3; ++c)
        color.at(x, y, static_cast<int>(c)) =
            count[c] == 0 ? std::uint8_t{0} : static_cast<std::uint8_t>((sum[c] + count[c] / 2) / count[c]);
    }
  return color;
}

}  // namespace plumbline
