#include "map/mesh_of_bricks.h"

#include <vector>

namespace plumbline {

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

std::vector<std::int32_t> entry_of_each(const std::vector<std::int32_t>& list, std::size_t count) {
  std::vector<std::int32_t> entries(count, -1);
  for (std::size_t i = 0; i < list.size(); ++i)
    entries[static_cast<std::size_t>(list[i])] = static_cast<std::int32_t>(i);
  return entries;
}

std::size_t first_of(const Backend& backend, const DeviceArray<std::int32_t>& scanned, int entry) {
  return static_cast<std::size_t>(scanned.download(backend, static_cast<std::size_t>(entry) + 1).back());
}

void transform_mesh(const SE3& world_from_mesh, Mesh* mesh) {
  const RigidTransform k = to_kernel(world_from_mesh);
  for (Mesh::Float3& p : mesh->positions) {
    const Vec3<float> q = k.apply(Vec3<float>{p.x, p.y, p.z});
    p = {q.x, q.y, q.z};
  }
  for (Mesh::Float3& n : mesh->normals) {
    const Vec3<float> q = k.rotate(Vec3<float>{n.x, n.y, n.z});
    n = {q.x, q.y, q.z};
  }
}

}  // namespace plumbline
