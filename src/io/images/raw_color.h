// Colour as cameras hand it out: YUV with halved chroma, and the mosaic of a Bayer filter.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "plumbline/image.h"

namespace plumbline {

/// Where two pixels' luma and their common chroma stand among four bytes.
struct YuvOrder {
  std::size_t first, second, u, v;
};

/// Of an encoding's name in ROS or V4L: "yuv422" and "uyvy" (U Y V Y), "yuv422_yuy2", "yuyv" and "yuy2" (Y U Y V).
std::optional<YuvOrder> yuv_order(std::string_view encoding);

/// Rows of `step` bytes, of BT.601 with luma from 16 to 235, as RGB; the width is even.
ColorImage decode_yuv(const std::uint8_t* bytes, std::size_t step, int width, int height, const YuvOrder& order);

/// Where red stands in each two by two pixels: column and row, 0 or 1. Blue stands across from it.
struct BayerOrder {
  int red_x, red_y;
};

/// Of an encoding's name in ROS: "bayer_rggb8", "bayer_bggr8", "bayer_gbrg8", "bayer_grbg8".
std::optional<BayerOrder> bayer_order(std::string_view encoding);

/// Rows of `step` bytes as RGB: what a pixel lacks is the mean of the neighbours that have it.
ColorImage decode_bayer(const std::uint8_t* bytes, std::size_t step, int width, int height, const BayerOrder& order);

}  // namespace plumbline
