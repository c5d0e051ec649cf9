// Images on the host, as files hold them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace plumbline {

/// A plain row-major host image, as files hold it: `channels` interleaved values a pixel, no padding.
template <class T>
struct Image {
  int width = 0, height = 0, channels = 1;
  std::vector<T> pixels;

  Image() = default;
  Image(int w, int h, int c = 1)
      : width(w),
        height(h),
        channels(c),
        pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) * static_cast<std::size_t>(c)) {}

  bool empty() const { return pixels.empty(); }
  T* row(int y) { return pixels.data() + offset(0, y); }
  const T* row(int y) const { return pixels.data() + offset(0, y); }
  T& at(int x, int y, int c = 0) { return pixels[offset(x, y) + static_cast<std::size_t>(c)]; }
  const T& at(int x, int y, int c = 0) const { return pixels[offset(x, y) + static_cast<std::size_t>(c)]; }

 private:
  std::size_t offset(int x, int y) const {
    return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
           static_cast<std::size_t>(channels);
  }
};

using DepthImage = Image<std::uint16_t>;  ///< raw readings; metres are reading / depth scale; 0 is no reading
using ColorImage = Image<std::uint8_t>;   ///< 3 channels, red green blue

}  // namespace plumbline
