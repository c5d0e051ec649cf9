// Nearest and farthest reading of a frame's tiles, level by level: what decides which bricks a frame can change.
#pragma once

#include <vector>

#include "backend/maps.h"
#include "core/device_array.h"
#include "kernels/integrate.h"
#include "plumbline/pinhole.h"

namespace plumbline {

/// In a backend's memory, made once and measured for every frame.
class DepthRanges {
 public:
  /// `backend` must outlive it.
  DepthRanges(const Pinhole& camera, const Backend& backend);

  /// Of a depth image (metres) of the camera's size.
  void measure(const Plane<float>& depth) const;
  const kernels::DepthRangeView& view() const { return view_; }

 private:
  struct Level {
    int first, columns, rows, stride;
  };

  const Backend* backend_;
  std::vector<Level> levels_;
  DeviceArray<float> nearest_, farthest_;
  DeviceArray<std::int32_t> first_, stride_;
  kernels::DepthRangeView view_;
};

}  // namespace plumbline
