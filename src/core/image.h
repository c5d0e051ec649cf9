// Images as padded planes, and the views of them that kernels take.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/macros.h"

namespace plumbline {

/// Zeroed memory of a device, at least 64-byte aligned; freed with the last copy of the pointer.
using Buffer = std::shared_ptr<void>;

/// Zeroed host memory whose pages cost nothing until they are first written. Throws std::bad_alloc.
Buffer allocate_host(std::size_t bytes);

/// One plane of an image as a kernel sees it. Every row has kPadding elements of zeros (an invalid reading) on either
/// side, so a stencil may read up to kPadding columns out of the image, and a lane may store past a row's end
/// provided that it stores zeros there. Rows above and below do not exist.
template <class T>
struct PlaneView {
  T* data = nullptr;
  int width = 0, height = 0, stride = 0;

  PL_HD T* row(int y) const { return data + static_cast<std::ptrdiff_t>(y) * stride; }
  PL_HD bool is_null() const { return data == nullptr; }
};

/// An owned plane in any device's memory.
template <class T>
class Plane {
 public:
  static constexpr int kPadding = 16;  ///< elements; a widest lane's worth

  Plane() = default;
  /// `allocate` gives zeroed memory (`allocate_host`, or a backend's).
  template <class Allocate>
  Plane(int width, int height, Allocate&& allocate)
      : width_(width), height_(height), stride_((width + kPadding - 1) / kPadding * kPadding + 2 * kPadding) {
    buffer_ = allocate(bytes());
  }

  PlaneView<T> view() const { return {static_cast<T*>(buffer_.get()) + kPadding, width_, height_, stride_}; }
  int width() const { return width_; }
  int height() const { return height_; }
  bool empty() const { return buffer_ == nullptr; }
  std::size_t bytes() const {
    return sizeof(T) * static_cast<std::size_t>(stride_) * static_cast<std::size_t>(height_);
  }
  void* storage() const { return buffer_.get(); }

 private:
  int width_ = 0, height_ = 0, stride_ = 0;
  Buffer buffer_;
};

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
