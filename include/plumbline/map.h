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

/// The bricks of a map that have changed, as they were between two frames: what a copy of the map that is kept
/// elsewhere, as for a preview, follows it by.
struct MapUpdate {
  double voxel_size = 0;  ///< metres
  double truncation = 0;  ///< metres
  SE3 world_from_map;
  std::vector<Map::Brick> bricks;
  /// Map::kBrickVoxels a brick, x fastest, then y: the low half is the signed distance in 1/32767 of the truncation,
  /// the high half the weight; 0: never seen.
  std::vector<std::int32_t> voxels;
  /// As `voxels`, a byte each of red, green, blue and weight, the lowest first; empty for a map without colour.
  std::vector<std::int32_t> colors;
  int waiting = 0;  ///< bricks that are to come with the next updates
};

}  // namespace plumbline
