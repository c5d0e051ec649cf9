// The volume's surface as a mesh on the host.
#include <algorithm>
#include <vector>

#include "map/volume.h"
#include "plumbline/mesh.h"
#include "plumbline/se3.h"

namespace plumbline {
namespace {

/// Removes vertices that no triangle uses: edges at the rim of what was seen carry one, but no cell is whole there.
void drop_unused_vertices(Mesh* mesh) {
  constexpr std::uint32_t kUnused = 0xFFFFFFFF;
  std::vector<std::uint32_t> renumbered(mesh->positions.size(), kUnused);
  for (const Mesh::Triangle& t : mesh->triangles) renumbered[t.a] = renumbered[t.b] = renumbered[t.c] = 0;
  std::uint32_t used = 0;
  for (std::size_t i = 0; i < renumbered.size(); ++i) {
    if (renumbered[i] == kUnused) continue;
    renumbered[i] = used;
    mesh->positions[used] = mesh->positions[i];
    mesh->normals[used] = mesh->normals[i];
    if (!mesh->colors.empty()) mesh->colors[used] = mesh->colors[i];
    ++used;
  }
  mesh->positions.resize(used);
  mesh->normals.resize(used);
  if (!mesh->colors.empty()) mesh->colors.resize(used);
  for (Mesh::Triangle& t : mesh->triangles) t = {renumbered[t.a], renumbered[t.b], renumbered[t.c]};
}

void transform(const SE3& world_from_volume, Mesh* mesh) {
  const RigidTransform k = to_kernel(world_from_volume);
  for (Mesh::Float3& p : mesh->positions) {
    const Vec3<float> q = k.apply(Vec3<float>{p.x, p.y, p.z});
    p = {q.x, q.y, q.z};
  }
  for (Mesh::Float3& n : mesh->normals) {
    const Vec3<float> q = k.rotate(Vec3<float>{n.x, n.y, n.z});
    n = {q.x, q.y, q.z};
  }
}

/// For each of `slots` bricks its entry in a list, −1 for those that are not listed.
std::vector<std::int32_t> entry_of_each(const std::vector<std::int32_t>& list, int slots) {
  std::vector<std::int32_t> entries(static_cast<std::size_t>(slots), -1);
  for (std::size_t i = 0; i < list.size(); ++i)
    entries[static_cast<std::size_t>(list[i])] = static_cast<std::int32_t>(i);
  return entries;
}

}  // namespace

Mesh Volume::extract_mesh(const MeshParameters& parameters) const {
  const Backend& backend = *backend_;
  const int slots = view_.slots();
  DeviceArray<std::int32_t> list(backend, static_cast<std::size_t>(slots));
  const int entries = backend.compact(view_.states(), slots, list.data());
  const auto count = static_cast<std::size_t>(entries);
  const DeviceArray<std::int32_t> position(backend, entry_of_each(list.download(backend, count), slots));
  const DeviceArray<kernels::CellTriangles> table(backend, kernels::kCellTable);
  const DeviceArray<kernels::EdgeRecord> edges(backend, count * kernels::kBrickVoxels);
  const DeviceArray<std::int32_t> vertex_count(backend, count), triangle_count(backend, count);

  // Never more than a voxel can have: that of a short run, or of a low cap.
  const int min_weight = std::min({std::max(frames_, 1), parameters.min_weight, parameters_.max_weight});
  const kernels::MeshBricks bricks{view_,
                                   list.data(),
                                   position.data(),
                                   edges.data(),
                                   vertex_count.data(),
                                   triangle_count.data(),
                                   table.data(),
                                   static_cast<float>(min_weight)};
  backend.run(kernels::CountBrick{bricks}, entries);
  const auto vertices = static_cast<std::size_t>(backend.scan(vertex_count.data(), entries));
  const auto triangles = static_cast<std::size_t>(backend.scan(triangle_count.data(), entries));

  Mesh mesh;
  if (triangles == 0) return mesh;
  const DeviceArray<Mesh::Float3> positions(backend, vertices), normals(backend, vertices);
  const DeviceArray<Mesh::Rgb> colors(backend, view_.has_color() ? vertices : 0);
  const DeviceArray<Mesh::Triangle> indices(backend, triangles);
  backend.run(kernels::WriteBrick{bricks, positions.parts<float>(), normals.parts<float>(),
                                  colors.parts<std::uint8_t>(), indices.parts<std::uint32_t>()},
              entries);
  mesh.positions = positions.download(backend);
  mesh.normals = normals.download(backend);
  mesh.triangles = indices.download(backend);
  mesh.colors = colors.download(backend);
  drop_unused_vertices(&mesh);
  transform(world_from_volume_, &mesh);
  return mesh;
}

}  // namespace plumbline
