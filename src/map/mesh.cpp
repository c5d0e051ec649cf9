// The volume's surface as a mesh on the host.
#include <algorithm>
#include <numeric>

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

}  // namespace

Mesh Volume::extract_mesh(const MeshParameters& parameters) const {
  const Backend& backend = *backend_;
  const auto slots = static_cast<std::size_t>(brick_slots());
  const auto ints = [&](std::size_t count) {
    return backend.allocate(std::max<std::size_t>(1, count) * sizeof(std::int32_t));
  };
  const auto as_ints = [](const Buffer& buffer) { return static_cast<std::int32_t*>(buffer.get()); };

  const Buffer list = ints(slots), position = ints(slots);
  const int entries = backend.compact(view_.occupied, brick_slots(), as_ints(list));
  const auto count = static_cast<std::size_t>(entries);
  std::vector<std::int32_t> host_list(count), host_position(slots, -1);
  backend.download(host_list.data(), list.get(), count * sizeof(std::int32_t));
  for (std::size_t i = 0; i < count; ++i)
    host_position[static_cast<std::size_t>(host_list[i])] = static_cast<std::int32_t>(i);
  backend.upload(position.get(), host_position.data(), slots * sizeof(std::int32_t));
  const Buffer table = backend.allocate(sizeof kernels::kCellTable);
  backend.upload(table.get(), kernels::kCellTable.data(), sizeof kernels::kCellTable);
  const Buffer edges =
      backend.allocate(std::max<std::size_t>(1, count) * kernels::kBrickVoxels * sizeof(kernels::EdgeRecord));
  const Buffer vertex_count = ints(count), triangle_count = ints(count);

  // Never more than a voxel can have: that of a short run, or of a low cap.
  const int min_weight = std::min({std::max(frames_, 1), parameters.min_weight, parameters_.max_weight});
  const kernels::MeshBricks bricks{view_,
                                   as_ints(list),
                                   as_ints(position),
                                   static_cast<kernels::EdgeRecord*>(edges.get()),
                                   as_ints(vertex_count),
                                   as_ints(triangle_count),
                                   static_cast<const kernels::CellTriangles*>(table.get()),
                                   static_cast<float>(min_weight)};
  backend.run(kernels::CountBrick{bricks}, entries);
  const auto vertices = static_cast<std::size_t>(backend.scan(bricks.vertex_count, entries));
  const auto triangles = static_cast<std::size_t>(backend.scan(bricks.triangle_count, entries));

  Mesh mesh;
  if (triangles == 0) return mesh;
  const bool with_color = view_.colors != nullptr;
  const Buffer positions = backend.allocate(vertices * sizeof(Mesh::Float3));
  const Buffer normals = backend.allocate(vertices * sizeof(Mesh::Float3));
  const Buffer colors = with_color ? backend.allocate(vertices * sizeof(Mesh::Rgb)) : nullptr;
  const Buffer indices = backend.allocate(triangles * sizeof(Mesh::Triangle));
  backend.run(kernels::WriteBrick{bricks, static_cast<float*>(positions.get()), static_cast<float*>(normals.get()),
                                  static_cast<std::uint8_t*>(colors.get()), static_cast<std::uint32_t*>(indices.get())},
              entries);
  mesh.positions.resize(vertices);
  mesh.normals.resize(vertices);
  mesh.triangles.resize(triangles);
  backend.download(mesh.positions.data(), positions.get(), vertices * sizeof(Mesh::Float3));
  backend.download(mesh.normals.data(), normals.get(), vertices * sizeof(Mesh::Float3));
  backend.download(mesh.triangles.data(), indices.get(), triangles * sizeof(Mesh::Triangle));
  if (with_color) {
    mesh.colors.resize(vertices);
    backend.download(mesh.colors.data(), colors.get(), vertices * sizeof(Mesh::Rgb));
  }
  drop_unused_vertices(&mesh);
  transform(world_from_volume_, &mesh);
  return mesh;
}

}  // namespace plumbline
