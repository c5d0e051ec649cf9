// The map that frames are fused into, as values.
#pragma once

#include <cstdint>
#include <vector>

#include "plumbline/se3.h"

namespace plumbline {

/// A truncated signed distance to the surface, in bricks of 8³ voxels; those that never held a surface are left out.
/// Voxel (i, j, k) is centred at (i + ½, j + ½, k + ½)·voxel_size in the map's frame.
struct Map {
  static constexpr int kBrickVoxels = 512;
  /// Lowest voxel of a brick, multiples of 8.
  struct Brick {
    std::int32_t x, y, z;
  };
  double voxel_size = 0;  ///< metres
  double truncation = 0;  ///< metres: no distance is greater
  SE3 world_from_map;
  std::vector<Brick> bricks;
  /// kBrickVoxels a brick, x fastest, then y: metres, positive on the free side; 0 where `weights` is.
  std::vector<float> distances;
  std::vector<std::uint16_t> weights;  ///< of `distances`: frames that saw the voxel, up to a cap; 0: none
};

}  // namespace plumbline
