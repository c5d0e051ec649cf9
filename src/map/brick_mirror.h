// A copy of the map on the host that follows it by updates and is meshed block by block, away from the frame loop.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "map/packed_bricks.h"
#include "plumbline/backend.h"
#include "plumbline/map.h"
#include "plumbline/mesh.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "plumbline/vec3.h"

namespace plumbline {

/// A cube of 4³ bricks, counted in blocks from the map's origin.
struct MapBlock {
  std::int32_t x, y, z;
  auto operator<=>(const MapBlock&) const = default;
};

/// A block whose surface an update reached.
struct ReachedBlock {
  MapBlock block;
  bool is_new;  ///< some of its bricks were not known before
};

/// Where the frames were taken that an update of the map comes from.
struct MapViews {
  Pinhole camera;
  std::vector<SE3> world_from_camera;
};

struct BlockSurface {
  Mesh mesh;  ///< world frame, metres
  /// One a vertex: how well it was seen. Frames that saw it, up to the map's cap, each by the cosine of the angle
  /// between its line of sight and the surface's normal, and by (1 m / distance)² where it was farther away than that.
  std::vector<double> seen;
};

class BrickMirror {
 public:
  /// 4 KiB a brick; once there are `max_bricks`, new ones are left out.
  explicit BrickMirror(std::size_t max_bricks);

  /// Takes the bricks over. Returns the blocks whose surface they reach, each once. What they gained in weight is the
  /// views' that have them in sight.
  std::vector<ReachedBlock> update(const MapUpdate& update, const MapViews& views = {});
  /// The surface in a block, of voxels that two frames saw or more; neighbouring blocks meet without a gap.
  BlockSurface surface(const MapBlock& block) const;

  double block_size() const;  ///< metres; 0 before the first update
  const SE3& world_from_map() const { return world_from_map_; }
  bool is_full() const { return bricks_.size() >= max_bricks_; }
  void clear() { bricks_.clear(); }

 private:
  struct Brick {
    BrickWords words;
    bool has_before = false, has_behind = false;  ///< voxels on either side of a surface
    double weight = 0, weight_in_view = 0;        ///< sums over the voxels; the second of what the views account for
    /// From the brick to the cameras, map's frame: the mean of directions by (1 m / distance)².
    Vec3<float> to_cameras{};
    void sum_up();
  };
  class Surroundings;
  Eigen::Vector3d corner_of(const kernels::VoxelPosition& brick) const;
  void note_views(const kernels::VoxelPosition& at, const MapViews& views, double weight_before, Brick* brick) const;
  double seen_at(const Surroundings& around, const Mesh::Float3& position, const Mesh::Float3& normal) const;

  std::size_t max_bricks_;
  double voxel_size_ = 0, truncation_ = 0;
  bool has_color_ = false;
  SE3 world_from_map_;
  std::unordered_map<BrickKey, Brick> bricks_;
  std::shared_ptr<Backend> host_;  ///< one thread
};

}  // namespace plumbline
