// From bricks to a mesh on the host: what the volume and the fine map share.
#pragma once

#include <cstdint>
#include <vector>

#include "backend/backend.h"
#include "core/device_array.h"
#include "kernels/marching_cubes.h"
#include "plumbline/mesh.h"
#include "plumbline/se3.h"

namespace plumbline {

/// Removes vertices that no triangle uses: edges at the rim of what was seen carry one, but no cell is whole there.
void drop_unused_vertices(Mesh* mesh);

/// From the map's frame, or from a part's of it, into the world's.
void transform_mesh(const SE3& world_from_mesh, Mesh* mesh);

/// For each of `count` bricks its entry in a list, −1 for those that are not listed.
std::vector<std::int32_t> entry_of_each(const std::vector<std::int32_t>& list, std::size_t count);

/// In the backend's memory.
struct ListedBricks {
  const std::int32_t* list;      ///< brick of each entry
  const std::int32_t* position;  ///< entry of each brick, −1 for those that are not listed
  int entries;
  int own = entries;  ///< the first so many: the others only bring vertices on the own bricks' upper faces
};

/// What a scan of counts leaves at an entry: how many all before it have together.
std::size_t first_of(const Backend& backend, const DeviceArray<std::int32_t>& scanned, int entry);

/// The surface in the own bricks, in the map's frame; empty where there is none. `stages`: the backend, or those of
/// it that know this map. Throws Error for more vertices or triangles than 31 bits count, std::bad_alloc.
template <class Map, class Stages>
Mesh mesh_of_bricks(const Backend& backend, const Stages& stages, const Map& map, const ListedBricks& listed,
                    int min_weight) {
  const auto count = static_cast<std::size_t>(listed.entries);
  const DeviceArray<kernels::CellTriangles> table(backend, kernels::kCellTable);
  const DeviceArray<kernels::EdgeRecord> edges(backend, count * kernels::kBrickVoxels);
  const DeviceArray<std::int32_t> vertex_count(backend, count), triangle_count(backend, count);
  const kernels::MeshBricksOf<Map> bricks{map,
                                          listed.list,
                                          listed.position,
                                          edges.data(),
                                          vertex_count.data(),
                                          triangle_count.data(),
                                          table.data(),
                                          static_cast<float>(min_weight)};
  stages.run(kernels::CountBrickOf<Map>{bricks}, listed.entries);
  const auto vertices = static_cast<std::size_t>(backend.scan(vertex_count.data(), listed.entries));
  const auto triangles = static_cast<std::size_t>(backend.scan(triangle_count.data(), listed.entries));

  Mesh mesh;
  const auto own = listed.own == listed.entries ? triangles : first_of(backend, triangle_count, listed.own);
  if (own == 0) return mesh;
  const DeviceArray<Mesh::Float3> positions(backend, vertices), normals(backend, vertices);
  const DeviceArray<Mesh::Rgb> colors(backend, map.has_color() ? vertices : 0);
  const DeviceArray<Mesh::Triangle> indices(backend, triangles);
  stages.run(kernels::WriteBrickOf<Map>{bricks, positions.template parts<float>(), normals.template parts<float>(),
                                        colors.template parts<std::uint8_t>(), indices.template parts<std::uint32_t>()},
             listed.entries);
  mesh.positions = positions.download(backend);
  mesh.normals = normals.download(backend);
  mesh.triangles = indices.download(backend, own);
  mesh.colors = colors.download(backend);
  drop_unused_vertices(&mesh);
  return mesh;
}

}  // namespace plumbline
