// Lens distortion taken out of depth and colour images once, on reading.
#pragma once

#include <cstdint>
#include <vector>

#include "plumbline/image.h"
#include "plumbline/pinhole.h"

namespace plumbline {

/// Resamples images of one camera so that a pure pinhole with the same intrinsics describes them.
class Undistorter {
 public:
  /// Builds the table of source positions. A zero distortion makes an identity that leaves images untouched.
  Undistorter(const Pinhole& camera, const Distortion& distortion);

  bool is_identity() const { return source_.empty(); }

  /// Depth is interpolated between the four neighbours only where they belong to one surface (all valid, spread within
  /// 2 % of the depth); elsewhere the nearest reading is taken, so no depth is invented across an edge.
  void apply(DepthImage& depth) const;
  /// Bilinear; pixels that fall out of the image are black.
  void apply(ColorImage& color) const;

 private:
  /// Where a pixel comes from in the distorted image.
  struct Source {
    std::int32_t cell;  ///< index of the top-left one of the four pixels around the position; −1 outside the image
    float ax, ay;       ///< the position's fraction between them, 0…1
  };
  static Source source_at(float x, float y, int width, int height);

  int width_ = 0, height_ = 0;
  std::vector<Source> source_;
};

}  // namespace plumbline
