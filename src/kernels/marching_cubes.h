// The surface of the volume as an indexed mesh. Every voxel owns the three edges that leave it upwards, so a vertex is
// made once and shared; a first pass counts, a scan places, a second pass writes.
#pragma once

#include <cstdint>

#include "kernels/lane.h"
#include "kernels/marching_cubes_table.h"
#include "kernels/volume_view.h"
#include "plumbline/vec3.h"

namespace plumbline::kernels {

/// Per voxel of the listed bricks: the vertex's rank in its brick (11 bits) and which of the voxel's edges carry one.
using EdgeRecord = std::uint16_t;
constexpr int kEdgeFlagBits = 3;

/// The bricks to mesh and where their output goes.
struct MeshBricks {
  VolumeView volume;
  const std::int32_t* list;                     ///< brick of each entry
  const std::int32_t* position;                 ///< entry of each brick, −1 for bricks that are not listed
  EdgeRecord* edges;                            ///< kBrickVoxels per entry
  std::int32_t *vertex_count, *triangle_count;  ///< per entry; after the scan the first of each
  const CellTriangles* table;                   ///< 256
  float min_weight;
};

struct VoxelPosition {
  int x, y, z;
};

PL_HD VoxelPosition voxel_position(const VolumeView& volume, int brick, int offset) {
  const int rest = brick / volume.brick_stride;
  return {brick % volume.brick_stride * kBrickSide + (offset & 7),
          rest % volume.bricks * kBrickSide + (offset >> 3 & 7), rest / volume.bricks * kBrickSide + (offset >> 6)};
}

PL_HD Voxel<float> read_voxel(const VolumeView& volume, int x, int y, int z) {
  return unpack<float>(volume.voxels[volume.index<std::int32_t>(x, y, z)]);
}

/// Edges that carry a vertex: both ends seen, one on either side of the surface.
PL_HD int crossed_edges(const MeshBricks& in, const VoxelPosition& p) {
  const Voxel<float> here = read_voxel(in.volume, p.x, p.y, p.z);
  if (here.weight < in.min_weight) return 0;
  const int last = in.volume.resolution() - 1;
  int flags = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int x = p.x + (axis == 0), y = p.y + (axis == 1), z = p.z + (axis == 2);
    if (x > last || y > last || z > last) continue;
    const Voxel<float> there = read_voxel(in.volume, x, y, z);
    if (there.weight >= in.min_weight && (here.distance < 0) != (there.distance < 0)) flags |= 1 << axis;
  }
  return flags;
}

/// Sign pattern of the cell whose lowest corner is p; 0 (no surface) where a corner was not seen.
PL_HD int cell_pattern(const MeshBricks& in, const VoxelPosition& p) {
  const int last = in.volume.resolution() - 1;
  if (p.x >= last || p.y >= last || p.z >= last) return 0;
  int inside = 0;
  for (int c = 0; c < 8; ++c) {
    const Voxel<float> corner = read_voxel(in.volume, p.x + (c & 1), p.y + (c >> 1 & 1), p.z + (c >> 2));
    if (corner.weight < in.min_weight) return 0;
    if (corner.distance < 0) inside |= 1 << c;
  }
  return inside;
}

/// First pass over one entry: which edges carry vertices, and how many vertices and triangles there are.
struct CountBrick {
  MeshBricks in;

  PL_HD void operator()(int entry) const {
    int vertices = 0, triangles = 0;
    for (int offset = 0; offset < kBrickVoxels; ++offset) {
      const VoxelPosition p = voxel_position(in.volume, in.list[entry], offset);
      const int flags = crossed_edges(in, p);
      in.edges[static_cast<std::ptrdiff_t>(entry) * kBrickVoxels + offset] =
          static_cast<EdgeRecord>(vertices << kEdgeFlagBits | flags);
      vertices += (flags & 1) + (flags >> 1 & 1) + (flags >> 2);
      triangles += in.table[cell_pattern(in, p)].count;
    }
    in.vertex_count[entry] = vertices;
    in.triangle_count[entry] = triangles;
  }
};

/// Second pass over one entry: positions (volume frame, metres), normals, colours and triangles.
struct WriteBrick {
  MeshBricks in;
  float* positions;          ///< 3 per vertex
  float* normals;            ///< 3 per vertex
  std::uint8_t* colors;      ///< 3 per vertex, or null
  std::uint32_t* triangles;  ///< 3 per triangle

  PL_HD void operator()(int entry) const {
    int vertex = in.vertex_count[entry], triangle = in.triangle_count[entry];
    for (int offset = 0; offset < kBrickVoxels; ++offset) {
      const int flags = in.edges[static_cast<std::ptrdiff_t>(entry) * kBrickVoxels + offset] & 7;
      const VoxelPosition p = voxel_position(in.volume, in.list[entry], offset);
      for (int axis = 0; axis < 3; ++axis) {
        if ((flags >> axis & 1) != 0) write_vertex(vertex++, p, axis);
      }
      const CellTriangles& cell = in.table[cell_pattern(in, p)];
      for (int i = 0; i < cell.count; ++i, ++triangle) {
        for (int k = 0; k < 3; ++k)
          triangles[3 * triangle + k] = vertex_of(p, cell.edges[static_cast<std::size_t>(3 * i + k)]);
      }
    }
  }

 private:
  /// Index of the vertex on a cell's edge: the edge belongs to its lower corner's voxel.
  PL_HD std::uint32_t vertex_of(const VoxelPosition& p, int edge) const {
    const int corner = edge_corner(edge), axis = edge / 4;
    const int x = p.x + (corner & 1), y = p.y + (corner >> 1 & 1), z = p.z + (corner >> 2);
    const int brick = in.volume.brick_index(x >> 3, y >> 3, z >> 3);
    const int entry = in.position[brick];
    const int offset = (x & 7) | (y & 7) << 3 | (z & 7) << 6;
    const int record = in.edges[static_cast<std::ptrdiff_t>(entry) * kBrickVoxels + offset];
    const int below = record & ((1 << axis) - 1);
    return static_cast<std::uint32_t>(in.vertex_count[entry] + (record >> kEdgeFlagBits) + (below & 1) +
                                      (below >> 1 & 1));
  }

  PL_HD void write_vertex(int vertex, const VoxelPosition& p, int axis) const {
    const int x = p.x + (axis == 0), y = p.y + (axis == 1), z = p.z + (axis == 2);
    const float here = read_voxel(in.volume, p.x, p.y, p.z).distance;
    const float there = read_voxel(in.volume, x, y, z).distance;
    // Kept off the ends, so that a distance of exactly zero does not make triangles without area.
    const float along = min(max(here / (here - there), 1e-3f), 1.0f - 1e-3f);
    const Vec3<float> grid = {static_cast<float>(p.x) + (axis == 0 ? along : 0.0f),
                              static_cast<float>(p.y) + (axis == 1 ? along : 0.0f),
                              static_cast<float>(p.z) + (axis == 2 ? along : 0.0f)};
    const float size = in.volume.voxel_size;
    float* position = positions + 3 * static_cast<std::ptrdiff_t>(vertex);
    position[0] = (grid.x + 0.5f) * size;
    position[1] = (grid.y + 0.5f) * size;
    position[2] = (grid.z + 0.5f) * size;

    Vec3<float> n = normal_at(grid);
    if (dot(n, n) < 0.5f) {  // at the rim of what was seen: along the edge is all that is known
      const float sign = here < there ? 1.0f : -1.0f;
      n = {axis == 0 ? sign : 0.0f, axis == 1 ? sign : 0.0f, axis == 2 ? sign : 0.0f};
    }
    float* normal = normals + 3 * static_cast<std::ptrdiff_t>(vertex);
    normal[0] = n.x;
    normal[1] = n.y;
    normal[2] = n.z;
    if (colors != nullptr) write_color(vertex, p, {x, y, z}, along);
  }

  /// Unit gradient of the signed distance, zeros where a voxel around was not seen.
  PL_HD Vec3<float> normal_at(const Vec3<float>& grid) const {
    const DistanceSampler<float> sampler{in.volume};
    bool known = sampler.inside(grid);
    const Vec3<float> g = sampler.gradient(grid, &known);
    const float squared = dot(g, g);
    if (!known || squared < 1e-12f) return {0.0f, 0.0f, 0.0f};
    return g * (1.0f / sqrt(squared));
  }

  PL_HD void write_color(int vertex, const VoxelPosition& a, const VoxelPosition& b, float along) const {
    const auto first = static_cast<std::uint32_t>(in.volume.colors[in.volume.index<std::int32_t>(a.x, a.y, a.z)]);
    const auto second = static_cast<std::uint32_t>(in.volume.colors[in.volume.index<std::int32_t>(b.x, b.y, b.z)]);
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

}  // namespace plumbline::kernels
