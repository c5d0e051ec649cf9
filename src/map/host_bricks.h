// A map of any extent, or a part of one, as the passes of marching cubes read it, in the host's memory.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/sparse_bricks.h"
#include "map/packed_bricks.h"
#include "plumbline/backend.h"
#include "plumbline/mesh.h"

namespace plumbline {

/// Positions are counted in bricks.
class HostBricks {
 public:
  /// `voxel_size` in metres.
  HostBricks(double voxel_size, bool with_color);

  /// Voxels with a weight below `min_weight` count as not seen. `truncation` in metres. No position twice.
  void add(const kernels::VoxelPosition& position, const BrickWords& words, double truncation, int min_weight);

  /// In the map's frame; empty where there is no surface. With all of the machine's threads, which do not change it.
  /// Throws Error for more elements than 31 bits count, std::bad_alloc.
  Mesh extract_mesh();
  /// The surface in the first `own` of the bricks that were added, on the host's backend; those before `listed` lie on
  /// the own ones' upper sides, and all others are only read. Throws as above.
  Mesh extract_mesh(const Backend& host, int own, int listed);

  bool has_color() const { return with_color_; }

 private:
  kernels::SparseBricks view_of_all();

  double voxel_size_, max_step_ = 0;
  bool with_color_;
  std::vector<float> distances_;
  std::vector<std::int32_t> evidence_, colors_, states_, x_, y_, z_, table_;
};

}  // namespace plumbline
