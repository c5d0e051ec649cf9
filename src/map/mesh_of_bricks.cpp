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

}  // namespace plumbline
