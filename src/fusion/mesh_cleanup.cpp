#include "fusion/mesh_cleanup.h"

#include <meshoptimizer.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "map/mesh_of_bricks.h"

namespace plumbline {
namespace {

/// Which piece each vertex belongs to, named by its first vertex.
class Pieces {
 public:
  explicit Pieces(const Mesh& mesh) : parent_(mesh.positions.size()) {
    std::iota(parent_.begin(), parent_.end(), 0U);
    for (const Mesh::Triangle& t : mesh.triangles) {
      join(t.a, t.b);
      join(t.b, t.c);
    }
  }
  std::uint32_t of(std::uint32_t vertex) {
    while (parent_[vertex] != vertex) vertex = parent_[vertex] = parent_[parent_[vertex]];
    return vertex;
  }

 private:
  void join(std::uint32_t a, std::uint32_t b) {
    a = of(a);
    b = of(b);
    if (a < b)
      parent_[b] = a;
    else
      parent_[a] = b;
  }

  std::vector<std::uint32_t> parent_;
};

double area_of(const Mesh& mesh, const Mesh::Triangle& t) {
  const auto corner = [&](std::uint32_t i) {
    const Mesh::Float3& p = mesh.positions[i];
    return Eigen::Vector3d(p.x, p.y, p.z);
  };
  return 0.5 * (corner(t.b) - corner(t.a)).cross(corner(t.c) - corner(t.a)).norm();
}

}  // namespace

double area_of(const Mesh& mesh) {
  double area = 0;
  for (const Mesh::Triangle& t : mesh.triangles) area += area_of(mesh, t);
  return area;
}

std::size_t remove_islands(double min_area, Mesh* mesh) {
  Pieces pieces(*mesh);
  std::vector<double> areas(mesh->positions.size(), 0);
  for (const Mesh::Triangle& t : mesh->triangles) areas[pieces.of(t.a)] += area_of(*mesh, t);
  std::size_t removed = 0;
  for (const double area : areas) removed += area > 0 && area < min_area ? 1 : 0;
  std::erase_if(mesh->triangles, [&](const Mesh::Triangle& t) { return areas[pieces.of(t.a)] < min_area; });
  drop_unused_vertices(mesh);
  return removed;
}

void simplify(std::size_t max_triangles, Mesh* mesh) {
  constexpr float kAnyError = 1;  // of the mesh's size: the budget decides
  if (mesh->triangles.size() <= max_triangles) return;
  std::vector<std::uint32_t> indices;
  indices.reserve(3 * mesh->triangles.size());
  for (const Mesh::Triangle& t : mesh->triangles) indices.insert(indices.end(), {t.a, t.b, t.c});
  std::vector<std::uint32_t> fewer(indices.size());
  fewer.resize(meshopt_simplify(fewer.data(), indices.data(), indices.size(), &mesh->positions.front().x,
                                mesh->positions.size(), sizeof(Mesh::Float3), 3 * max_triangles, kAnyError));
  mesh->triangles.resize(fewer.size() / 3);
  for (std::size_t i = 0; i < mesh->triangles.size(); ++i)
    mesh->triangles[i] = {fewer[3 * i], fewer[3 * i + 1], fewer[3 * i + 2]};
  drop_unused_vertices(mesh);
}

}  // namespace plumbline
