// The surface of a map of bricks as an indexed mesh. Every voxel owns the three edges that leave it upwards, so a
// vertex is made once and shared; a first pass counts, a scan places, a second pass writes. The map is the volume or
// one that tells by its own `MeshVoxels` how its voxels are read.
#pragma once

#include <cstdint>

#include "kernels/brick_map.h"
#include "kernels/distance_sampler.h"
#include "kernels/lane.h"
#include "kernels/marching_cubes_table.h"
#include "kernels/voxel.h"
#include "plumbline/vec3.h"

namespace plumbline::kernels {

/// Per voxel of the listed bricks: the vertex's rank in its brick (11 bits) and which of the voxel's edges carry one.
using EdgeRecord = std::uint16_t;
constexpr int kEdgeFlagBits = 3;
constexpr int kEdgeFlags = (1 << kEdgeFlagBits) - 1;

/// The voxels of a brick and around it as the passes below read them.
template <class Map>
class MeshVoxels;

template <>
class MeshVoxels<BrickMap> {
 public:
  PL_HD MeshVoxels(const BrickMap& volume, int brick, float min_weight)
      : volume_(volume), around_(volume, brick), min_weight_(min_weight) {}

  /// The brick's lowest voxel.
  PL_HD const VoxelPosition& origin() const { return around_.origin(); }
  /// False where no cell of the brick can hold a surface, which is not looked for here.
  PL_HD static bool has_surface() { return true; }
  PL_HD VoxelAddress find(const VoxelPosition& p) const { return around_.find(p); }
  /// False where there is no voxel, or one that was not seen often enough.
  PL_HD bool read(const VoxelPosition& p, float* distance) const {
    const VoxelAddress at = around_.find(p);
    if (at.brick < 0) return false;
    const Voxel<float> voxel = unpack<float>(volume_.voxel(at));
    *distance = voxel.distance;
    return voxel.weight >= min_weight_;
  }
  /// Whether a surface between two voxels with such distances is one.
  PL_HD static bool is_surface(float /*here*/, float /*there*/) { return true; }
  /// Gradient (unscaled) of the signed distance between a voxel and the next along an axis; false where a voxel around
  /// was not seen.
  PL_HD bool gradient(const VoxelPosition& p, int axis, float along, Vec3<float>* g) const {
    const DistanceSampler<float> sampler{volume_};
    const Vec3<float> grid = {static_cast<float>(origin().x + p.x) + (axis == 0 ? along : 0.0f),
                              static_cast<float>(origin().y + p.y) + (axis == 1 ? along : 0.0f),
                              static_cast<float>(origin().z + p.z) + (axis == 2 ? along : 0.0f)};
    bool known = sampler.inside(grid);
    *g = sampler.gradient(grid, &known);
    return known;
  }

 private:
  const BrickMap& volume_;
  BrickNeighbours around_;
  float min_weight_;
};

/// The bricks to mesh and where their output goes.
template <class Map>
struct MeshBricksOf {
  Map volume;
  const std::int32_t* list;                     ///< brick of each entry
  const std::int32_t* position;                 ///< entry of each brick, −1 for bricks that are not listed
  EdgeRecord* edges;                            ///< kBrickVoxels per entry
  std::int32_t *vertex_count, *triangle_count;  ///< per entry; after the scan the first of each
  const CellTriangles* table;                   ///< 256
  float min_weight;

  PL_HD EdgeRecord& record(int entry, int offset) const {
    return edges[static_cast<std::ptrdiff_t>(entry) * kBrickVoxels + offset];
  }
};

/// A brick's surroundings as cells.
template <class Map>
struct MeshCells {
  const MeshBricksOf<Map>& in;
  MeshVoxels<Map> voxels;

  PL_HD MeshCells(const MeshBricksOf<Map>& bricks, int entry)
      : in(bricks), voxels(bricks.volume, bricks.list[entry], bricks.min_weight) {}

  /// Edges that carry a vertex: both ends seen, one on either side of the surface.
  PL_HD int crossed_edges(const VoxelPosition& p) const {
    float here = 0, there = 0;
    if (!voxels.read(p, &here)) return 0;
    int flags = 0;
    for (int axis = 0; axis < 3; ++axis) {
      if (voxels.read(one_along(p, axis), &there) && (here < 0) != (there < 0) && voxels.is_surface(here, there))
        flags |= 1 << axis;
    }
    return flags;
  }

  /// Sign pattern of the cell whose lowest corner is p; 0 (no surface) where a corner was not seen, or what lies
  /// between two is no surface.
  PL_HD int pattern(const VoxelPosition& p) const {
    float corner[8] = {};
    int inside = 0;
    for (int c = 0; c < 8; ++c) {
      if (!voxels.read(corner_of(p, c), &corner[c])) return 0;
      if (corner[c] < 0) inside |= 1 << c;
    }
    if (inside == 0 || inside == 0xFF) return inside;
    for (int edge = 0; edge < kCellEdges; ++edge) {
      const int low = edge_corner(edge), high = low | 1 << (edge / 4);
      if ((corner[low] < 0) != (corner[high] < 0) && !voxels.is_surface(corner[low], corner[high])) return 0;
    }
    return inside;
  }

  /// Index of the vertex on an edge of the cell at p: the edge belongs to its lower corner's voxel.
  PL_HD std::uint32_t vertex_of(const VoxelPosition& p, int edge) const {
    const int axis = edge / 4;
    const VoxelAddress at = voxels.find(corner_of(p, edge_corner(edge)));
    const int entry = in.position[at.brick];
    const int record = in.record(entry, at.offset);
    const int below = record & ((1 << axis) - 1);
    return static_cast<std::uint32_t>(in.vertex_count[entry] + (record >> kEdgeFlagBits) + (below & 1) +
                                      (below >> 1 & 1));
  }

  PL_HD static VoxelPosition one_along(const VoxelPosition& p, int axis) {
    return {p.x + (axis == 0), p.y + (axis == 1), p.z + (axis == 2)};
  }
  PL_HD static VoxelPosition corner_of(const VoxelPosition& p, int c) {
    return {p.x + (c & 1), p.y + (c >> 1 & 1), p.z + (c >> 2)};
  }
};

/// First pass over one entry: which edges carry vertices, and how many vertices and triangles there are.
template <class Map>
struct CountBrickOf {
  MeshBricksOf<Map> in;

  PL_HD void operator()(int entry) const {
    const MeshCells<Map> cells(in, entry);
    int vertices = 0, triangles = 0;
    for (int offset = 0; cells.voxels.has_surface() && offset < kBrickVoxels; ++offset) {
      const VoxelPosition p = position_in_brick(offset);
      const int flags = cells.crossed_edges(p);
      in.record(entry, offset) = static_cast<EdgeRecord>(vertices << kEdgeFlagBits | flags);
      vertices += (flags & 1) + (flags >> 1 & 1) + (flags >> 2);
      triangles += in.table[cells.pattern(p)].count;
    }
    in.vertex_count[entry] = vertices;
    in.triangle_count[entry] = triangles;
  }
};

/// Second pass over one entry: positions (volume frame, metres), normals, colours and triangles.
template <class Map>
struct WriteBrickOf {
  MeshBricksOf<Map> in;
  float* positions;          ///< 3 per vertex
  float* normals;            ///< 3 per vertex
  std::uint8_t* colors;      ///< 3 per vertex, or null
  std::uint32_t* triangles;  ///< 3 per triangle

  PL_HD void operator()(int entry) const {
    const MeshCells<Map> cells(in, entry);
    int vertex = in.vertex_count[entry], triangle = in.triangle_count[entry];
    for (int offset = 0; cells.voxels.has_surface() && offset < kBrickVoxels; ++offset) {
      const int flags = in.record(entry, offset) & kEdgeFlags;
      const VoxelPosition p = position_in_brick(offset);
      for (int axis = 0; axis < 3; ++axis) {
        if ((flags >> axis & 1) != 0) write_vertex(vertex++, cells.voxels, p, axis);
      }
      const CellTriangles& cell = in.table[cells.pattern(p)];
      for (int i = 0; i < cell.count; ++i, ++triangle) {
        for (int k = 0; k < 3; ++k)
          triangles[3 * triangle + k] = cells.vertex_of(p, cell.edges[static_cast<std::size_t>(3 * i + k)]);
      }
    }
  }

 private:
  PL_HD void write_vertex(int vertex, const MeshVoxels<Map>& voxels, const VoxelPosition& p, int axis) const {
    const VoxelPosition next = MeshCells<Map>::one_along(p, axis);
    float here = 0, there = 0;
    voxels.read(p, &here);
    voxels.read(next, &there);
    // Kept off the ends, so that a distance of exactly zero does not make triangles without area.
    const float along = min(max(here / (here - there), 1e-3f), 1.0f - 1e-3f);
    const VoxelPosition& origin = voxels.origin();
    const Vec3<float> grid = {static_cast<float>(origin.x + p.x) + (axis == 0 ? along : 0.0f),
                              static_cast<float>(origin.y + p.y) + (axis == 1 ? along : 0.0f),
                              static_cast<float>(origin.z + p.z) + (axis == 2 ? along : 0.0f)};
    const float size = in.volume.voxel_size;
    float* position = positions + 3 * static_cast<std::ptrdiff_t>(vertex);
    position[0] = (grid.x + 0.5f) * size;
    position[1] = (grid.y + 0.5f) * size;
    position[2] = (grid.z + 0.5f) * size;

    Vec3<float> n;
    if (!normal_at(voxels, p, axis, along, &n)) {  // at the rim of what was seen: along the edge is all that is known
      const float sign = here < there ? 1.0f : -1.0f;
      n = {axis == 0 ? sign : 0.0f, axis == 1 ? sign : 0.0f, axis == 2 ? sign : 0.0f};
    }
    float* normal = normals + 3 * static_cast<std::ptrdiff_t>(vertex);
    normal[0] = n.x;
    normal[1] = n.y;
    normal[2] = n.z;
    if (colors != nullptr) write_color(vertex, voxels.find(p), voxels.find(next), along);
  }

  /// Unit gradient of the signed distance; false where a voxel around was not seen.
  PL_HD static bool normal_at(const MeshVoxels<Map>& voxels, const VoxelPosition& p, int axis, float along,
                              Vec3<float>* n) {
    Vec3<float> g;
    const bool known = voxels.gradient(p, axis, along, &g);
    const float squared = dot(g, g);
    if (!known || squared < 1e-12f) return false;
    *n = g * (1.0f / sqrt(squared));
    return true;
  }

  PL_HD void write_color(int vertex, const VoxelAddress& a, const VoxelAddress& b, float along) const {
    const auto first = static_cast<std::uint32_t>(in.volume.color(a));
    const auto second = static_cast<std::uint32_t>(in.volume.color(b));
    const float seen_first = (first >> 24) != 0 ? 1.0f - along : 0.0f;
    const float seen_second = (second >> 24) != 0 ? along : 0.0f;
    const float total = seen_first + seen_second;
    for (int c = 0; c < 3; ++c) {
      const float sum = seen_first * static_cast<float>(first >> (8 * c) & 0xFF) +
                        seen_second * static_cast<float>(second >> (8 * c) & 0xFF);
      colors[3 * static_cast<std::ptrdiff_t>(vertex) + c] =
          total > 0.0f ? static_cast<std::uint8_t>(sum / total + 0.5f) : static_cast<std::uint8_t>(128);
    }
  }
};

// Of the volume.
using MeshBricks = MeshBricksOf<BrickMap>;
using CountBrick = CountBrickOf<BrickMap>;
using WriteBrick = WriteBrickOf<BrickMap>;

}  // namespace plumbline::kernels
