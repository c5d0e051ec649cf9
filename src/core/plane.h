// Images in a device's memory as padded planes, and the views of them that kernels take.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/device_array.h"
#include "plumbline/macros.h"

namespace plumbline {

constexpr int kMaxLaneWidth = 16;  ///< elements

/// A row of so many elements, and what fills the final lane.
constexpr int padded_to_lanes(int elements) { return (elements + kMaxLaneWidth - 1) / kMaxLaneWidth * kMaxLaneWidth; }

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
  static constexpr int kPadding = kMaxLaneWidth;

  Plane() = default;
  /// Zeros. Throws std::bad_alloc.
  Plane(int width, int height, const DeviceMemory& memory)
      : width_(width),
        height_(height),
        stride_(padded_to_lanes(width) + 2 * kPadding),
        elements_(memory, static_cast<std::size_t>(stride_) * static_cast<std::size_t>(height)) {}

  PlaneView<T> view() const { return {elements_.data() + kPadding, width_, height_, stride_}; }
  int width() const { return width_; }
  int height() const { return height_; }
  bool empty() const { return elements_.empty(); }
  /// Rows of `view().stride`, each with its padding on either side.
  const DeviceArray<T>& elements() const { return elements_; }

 private:
  int width_ = 0, height_ = 0, stride_ = 0;
  DeviceArray<T> elements_;
};

}  // namespace plumbline
