// A copy of the map on the host that follows it by updates and is meshed block by block, away from the frame loop.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "plumbline/map.h"
#include "plumbline/mesh.h"

namespace plumbline {

/// A cube of 4³ bricks, counted in blocks from the map's origin.
struct MapBlock {
  std::int32_t x, y, z;
  auto operator<=>(const MapBlock&) const = default;
};

struct BlockSurface {
  Mesh mesh;                    ///< world frame, metres
  std::vector<double> weights;  ///< one a vertex: frames that saw it, up to the map's cap
};

class BrickMirror {
 public:
  /// 4 KiB a brick; once there are `max_bricks`, new ones are left out.
  explicit BrickMirror(std::size_t max_bricks) : max_bricks_(max_bricks) {}

  /// Takes the bricks over. Returns the blocks whose surface they reach, each once.
  std::vector<MapBlock> update(const MapUpdate& update);
  /// The surface in a block, of voxels that two frames saw or more; neighbouring blocks meet without a gap.
  BlockSurface surface(const MapBlock& block) const;

  bool is_full() const { return bricks_.size() >= max_bricks_; }
  void clear() { bricks_.clear(); }

 private:
  struct Brick {
    std::array<std::int32_t, Map::kBrickVoxels> voxels, colors;
  };
  struct Position {  ///< counted in bricks
    std::int32_t x, y, z;
    auto operator<=>(const Position&) const = default;
  };
  friend class MirroredBlock;

  std::size_t max_bricks_;
  double voxel_size_ = 0;
  bool has_color_ = false;
  SE3 world_from_map_;
  std::map<Position, Brick> bricks_;
};

}  // namespace plumbline
