// The fine map of the final fusion as kernels see it: bricks anywhere, found through a hash of their positions. A voxel
// holds a distance in metres and what speaks for and against it (docs/method.md §10).
#pragma once

#include "kernels/brick_map.h"
#include "kernels/lane.h"
#include "kernels/marching_cubes.h"
#include "plumbline/vec3.h"

namespace plumbline::kernels {

/// Above any distance: of a voxel that is not known.
constexpr float kUnknownDistance = 1e30f;

/// What speaks for a voxel's distance: its weight, how many readings met the surface near it, and how many saw through
/// it. One word: a float of which the upper half is kept, and a byte each.
template <class F>
struct Evidence {
  F weight, hits, through;

  /// Both counts are halved when one is full, so that their ratio stays. The weight is rounded to 8 bits: beyond some
  /// 512 times a reading's own, that reading no longer adds to it, and the average goes on moving.
  PL_HD Int<F> pack() const {
    const Int<F> half = bits_from_float(weight) + Int<F>(0x8000);
    const F scale = select(max(hits, through) > F(255.0f), F(0.5f), F(1.0f));
    return (half & Int<F>(~0xFFFF)) | shift_left<8>(to_int(hits * scale)) | to_int(through * scale);
  }
  PL_HD static Evidence unpack(const Int<F>& word) {
    const Int<F> byte(0xFF);
    return {float_from_bits(word & Int<F>(~0xFFFF)), to_float(shift_right<8>(word) & byte), to_float(word & byte)};
  }
};

/// Voxel (i, j, k) is centred at (i + ½, j + ½, k + ½)·voxel_size in the world; negative positions are as good. A brick
/// is named by the number under which it was made. Whoever makes bricks keeps the table (fusion/fine_map).
class SparseBricks {
 public:
  float voxel_size = 0;              ///< metres
  float max_through = 0;             ///< readings that may see through a voxel, for each that met the surface near it
  float max_step = 0;                ///< metres by which distances of neighbours on a surface may differ
  float* distances = nullptr;        ///< metres, positive before the surface; kBrickVoxels a brick, as those below
  std::int32_t* evidence = nullptr;  ///< `Evidence`; 0: never seen
  std::int32_t* colors = nullptr;    ///< a byte each of red, green, blue and weight; null without
  std::int32_t* states = nullptr;    ///< one a brick: 0, kBrickSolid or kBrickFree
  std::int32_t *x = nullptr, *y = nullptr, *z = nullptr;  ///< a brick's position, counted in bricks
  std::int32_t* table = nullptr;                          ///< 1 + brick, by hash and then one after the other; 0: none
  std::uint32_t table_mask = 0;                           ///< entries of the table, a power of two, less 1
  std::int32_t bricks = 0;

  PL_HD bool has_color() const { return colors != nullptr; }
  PL_HD float brick_size() const { return kBrickSide * voxel_size; }  ///< metres
  PL_HD std::int32_t& state(int brick) const { return states[brick]; }
  PL_HD VoxelPosition origin_of(int brick) const {
    return {kBrickSide * x[brick], kBrickSide * y[brick], kBrickSide * z[brick]};
  }
  PL_HD static std::ptrdiff_t first_word(int brick) { return static_cast<std::ptrdiff_t>(brick) * kBrickVoxels; }
  PL_HD std::int32_t& color(const VoxelAddress& at) const { return colors[first_word(at.brick) + at.offset]; }

  /// Where the table's search for a brick at this position begins (Teschner et al. 2003).
  PL_HD std::uint32_t hash(const VoxelPosition& p) const {
    const auto part = [](std::int32_t value, std::uint32_t prime) { return static_cast<std::uint32_t>(value) * prime; };
    std::uint32_t h = part(p.x, 73856093U) ^ part(p.y, 19349669U) ^ part(p.z, 83492791U);
    h ^= h >> 15;
    return h & table_mask;
  }
  /// Entry of the table with the brick at this position, or the free one where it belongs.
  PL_HD std::uint32_t entry_of(const VoxelPosition& p) const {
    std::uint32_t entry = hash(p);
    while (table[entry] != 0) {
      const std::int32_t brick = table[entry] - 1;
      if (x[brick] == p.x && y[brick] == p.y && z[brick] == p.z) break;
      entry = (entry + 1) & table_mask;
    }
    return entry;
  }
  /// −1 where there is none.
  PL_HD std::int32_t find_brick(const VoxelPosition& p) const { return table[entry_of(p)] - 1; }

  /// Makes a brick at a position that has none, for whoever keeps the memory: there must be room.
  std::int32_t make_brick(const VoxelPosition& p) {
    const std::int32_t brick = bricks++;
    x[brick] = p.x;
    y[brick] = p.y;
    z[brick] = p.z;
    table[entry_of(p)] = brick + 1;
    return brick;
  }

  /// kUnknownDistance of a voxel that too few readings met. One that more of them saw through is free: it counts as a
  /// voxel's side before a surface, so that a silhouette closes where nothing was measured beside it.
  PL_HD float distance_of(std::ptrdiff_t word, float min_hits) const {
    const Evidence<float> e = Evidence<float>::unpack(evidence[word]);
    if (e.through > max_through * e.hits) return e.through >= min_hits ? voxel_size : kUnknownDistance;
    return e.hits >= min_hits ? distances[word] : kUnknownDistance;
  }
};

/// Reads all voxels that a brick's cells and their normals need once, from up to 27 bricks.
template <>
class MeshVoxels<SparseBricks> {
 public:
  PL_HD MeshVoxels(const SparseBricks& map, int brick, float min_hits)
      : origin_(map.origin_of(brick)), max_step_(map.max_step) {
    find_bricks({map.x[brick], map.y[brick], map.z[brick]}, map);
    int next = 0;
    for (int z = kBegin; z < kEnd; ++z) {
      for (int y = kBegin; y < kEnd; ++y) {
        for (int x = kBegin; x < kEnd; ++x) {
          const VoxelAddress at = find({x, y, z});
          const float d = at.brick < 0 ? kUnknownDistance
                                       : map.distance_of(SparseBricks::first_word(at.brick) + at.offset, min_hits);
          distances_[next++] = d;
          if (min_int(min_int(x, y), z) < 0 || max_int(max_int(x, y), z) > kBrickSide) continue;
          has_behind_ = has_behind_ || d < 0;
          has_before_ = has_before_ || (d >= 0 && d < kUnknownDistance);
        }
      }
    }
  }

  PL_HD const VoxelPosition& origin() const { return origin_; }
  /// False where no cell of the brick can hold a surface.
  PL_HD bool has_surface() const { return has_behind_ && has_before_; }
  PL_HD VoxelAddress find(const VoxelPosition& p) const {
    const VoxelPosition b = brick_of(p);
    return {bricks_[(b.z + 1) * 9 + (b.y + 1) * 3 + b.x + 1], offset_in_brick(p)};
  }
  PL_HD bool read(const VoxelPosition& p, float* distance) const {
    *distance = at(p);
    return *distance < kUnknownDistance;
  }
  /// Distances of voxels on either side of a surface differ by a voxel at the most, and by the noise. Where the back of
  /// what was seen meets free space, they jump.
  PL_HD bool is_surface(float here, float there) const { return abs(here - there) <= max_step_; }
  PL_HD bool gradient(const VoxelPosition& p, int axis, float along, Vec3<float>* g) const {
    const VoxelPosition next = {p.x + (axis == 0), p.y + (axis == 1), p.z + (axis == 2)};
    const Vec3<float> first = gradient_at(p), second = gradient_at(next);
    *g = first * (1.0f - along) + second * along;
    return true;
  }

 private:
  static constexpr int kBegin = -1, kEnd = kBrickSide + 2, kSide = kEnd - kBegin;

  PL_HD void find_bricks(const VoxelPosition& own, const SparseBricks& map) {
    int next = 0;
    for (int z = -1; z <= 1; ++z) {
      for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) bricks_[next++] = map.find_brick({own.x + x, own.y + y, own.z + z});
      }
    }
  }
  PL_HD float at(const VoxelPosition& p) const {
    return distances_[((p.z - kBegin) * kSide + p.y - kBegin) * kSide + p.x - kBegin];
  }
  /// By the voxels before and after, or by the one that is known.
  PL_HD float difference(const VoxelPosition& p, const VoxelPosition& before, const VoxelPosition& after) const {
    const float low = at(before), here = at(p), high = at(after);
    const bool has_low = low < kUnknownDistance, has_high = high < kUnknownDistance;
    if (has_low && has_high) return high - low;
    if (has_high) return 2.0f * (high - here);
    return has_low ? 2.0f * (here - low) : 0.0f;
  }
  PL_HD Vec3<float> gradient_at(const VoxelPosition& p) const {
    return {difference(p, {p.x - 1, p.y, p.z}, {p.x + 1, p.y, p.z}),
            difference(p, {p.x, p.y - 1, p.z}, {p.x, p.y + 1, p.z}),
            difference(p, {p.x, p.y, p.z - 1}, {p.x, p.y, p.z + 1})};
  }

  VoxelPosition origin_;
  float max_step_;
  bool has_behind_ = false, has_before_ = false;
  std::int32_t bricks_[27];
  float distances_[kSide * kSide * kSide];
};

using MeshFineBricks = MeshBricksOf<SparseBricks>;
using CountFineBrick = CountBrickOf<SparseBricks>;
using WriteFineBrick = WriteBrickOf<SparseBricks>;

}  // namespace plumbline::kernels
