#include "view/packed_mesh.h"
#include "plumbline/mesh.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace plumbline::app {
namespace {

// Of the mesh's size: far above what half a million triangles of a room need, so that the budget decides.
constexpr float kLargestError = 0.05f;
/// Of a level: its share of the triangles of the one before, and the error that is allowed for it, of the mesh's size.
struct Coarseness {
  double share;
  float max_error;
};
constexpr std::array<Coarseness, 2> kLevels = {{{0.17, 0.03f}, {0.2, 0.1f}}};
constexpr std::uint32_t kUnused = ~0U;

std::vector<std::uint32_t> indices_of(const Mesh& mesh) {
  std::vector<std::uint32_t> indices;
  indices.reserve(3 * mesh.triangles.size());
  for (const Mesh::Triangle& t : mesh.triangles) indices.insert(indices.end(), {t.a, t.b, t.c});
  return indices;
}

/// Collapses edges (Garland and Heckbert 1997) down to the budget. Where the topology does not allow that, as in a
/// heap of loose triangles, vertices are clustered.
std::vector<std::uint32_t> decimated(const Mesh& mesh, std::size_t triangle_budget) {
  std::vector<std::uint32_t> indices = indices_of(mesh);
  if (mesh.triangles.size() <= triangle_budget) return indices;
  const float* positions = &mesh.positions.front().x;
  std::vector<std::uint32_t> fewer(indices.size());
  std::size_t count = meshopt_simplify(fewer.data(), indices.data(), indices.size(), positions, mesh.positions.size(),
                                       sizeof(Mesh::Float3), 3 * triangle_budget, kLargestError);
  if (count > 4 * triangle_budget)
    count = meshopt_simplifySloppy(fewer.data(), indices.data(), indices.size(), positions, mesh.positions.size(),
                                   sizeof(Mesh::Float3), 3 * triangle_budget, 1.0f);
  fewer.resize(count);
  return fewer;
}

/// Orders triangles and vertices as they are drawn, and tells for each new vertex the old one.
std::vector<std::uint32_t> order(std::vector<std::uint32_t>* indices, std::size_t vertices) {
  meshopt_optimizeVertexCache(indices->data(), indices->data(), indices->size(), vertices);
  std::vector<std::uint32_t> remap(vertices);
  const std::size_t used = meshopt_optimizeVertexFetchRemap(remap.data(), indices->data(), indices->size(), vertices);
  meshopt_remapIndexBuffer(indices->data(), indices->data(), indices->size(), remap.data());
  std::vector<std::uint32_t> source(used);
  for (std::uint32_t i = 0; i < remap.size(); ++i)
    if (remap[i] != kUnused) source[remap[i]] = i;
  return source;
}

/// Every nth point, so that the budget holds.
std::vector<std::uint32_t> thinned(std::size_t points) {
  const std::size_t stride = (points + kPointBudget - 1) / kPointBudget;
  std::vector<std::uint32_t> source;
  for (std::size_t i = 0; i < points; i += std::max<std::size_t>(1, stride))
    source.push_back(static_cast<std::uint32_t>(i));
  return source;
}

/// `value(old vertex)` gives four components.
template <class T, class Value>
std::string encoded(const std::vector<std::uint32_t>& source, Value&& value) {
  std::vector<std::array<T, 4>> stream;
  stream.reserve(source.size());
  for (const std::uint32_t i : source) stream.push_back(value(i));
  std::string bytes(meshopt_encodeVertexBufferBound(stream.size(), sizeof stream[0]), '\0');
  bytes.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(bytes.data()), bytes.size(), stream.data(),
                                          stream.size(), sizeof stream[0]));
  return bytes;
}

std::string encoded_indices(const std::vector<std::uint32_t>& indices, std::size_t vertices) {
  if (indices.empty()) return {};
  std::string bytes(meshopt_encodeIndexBufferBound(indices.size(), vertices), '\0');
  bytes.resize(meshopt_encodeIndexBuffer(reinterpret_cast<unsigned char*>(bytes.data()), bytes.size(), indices.data(),
                                         indices.size()));
  return bytes;
}

Eigen::Vector3d finite(const Mesh::Float3& p) {
  const auto number = [](float x) { return std::isfinite(x) ? static_cast<double>(x) : 0.0; };
  return {number(p.x), number(p.y), number(p.z)};
}

MeshGrid grid_around(const Mesh& mesh, const std::vector<std::uint32_t>& source) {
  Eigen::Vector3d low = finite(mesh.positions[source.front()]), high = low;
  for (const std::uint32_t i : source) {
    low = low.cwiseMin(finite(mesh.positions[i]));
    high = high.cwiseMax(finite(mesh.positions[i]));
  }
  return {low, std::max(1e-9, (high - low).maxCoeff() / 65535)};
}

void pack_positions(const Mesh& mesh, const std::vector<std::uint32_t>& source, const MeshGrid& grid,
                    PackedMesh* packed) {
  packed->origin = grid.origin;
  packed->step = grid.step;
  packed->positions = encoded<std::uint16_t>(source, [&](std::uint32_t i) {
    const Eigen::Vector3d p = (finite(mesh.positions[i]) - grid.origin) / grid.step;
    const auto whole = [](double x) { return static_cast<std::uint16_t>(std::lround(std::clamp(x, 0.0, 65535.0))); };
    return std::array<std::uint16_t, 4>{whole(p.x()), whole(p.y()), whole(p.z()), 0};
  });
}

void pack_attributes(const Mesh& mesh, const std::vector<double>& errors, double error_range,
                     const std::vector<std::uint32_t>& source, PackedMesh* packed) {
  if (!mesh.normals.empty())
    packed->normals = encoded<std::int8_t>(source, [&](std::uint32_t i) {
      const Eigen::Vector3d n = 127 * finite(mesh.normals[i]).cwiseMax(-1).cwiseMin(1);
      const auto whole = [](double x) { return static_cast<std::int8_t>(std::lround(x)); };
      return std::array<std::int8_t, 4>{whole(n.x()), whole(n.y()), whole(n.z()), 0};
    });
  if (!mesh.colors.empty())
    packed->colors = encoded<std::uint8_t>(source, [&](std::uint32_t i) {
      return std::array<std::uint8_t, 4>{mesh.colors[i].r, mesh.colors[i].g, mesh.colors[i].b, 255};
    });
  if (!errors.empty())
    packed->errors = encoded<std::uint8_t>(source, [&](std::uint32_t i) {
      const double share = std::clamp(errors[i] / error_range, 0.0, 1.0);
      return std::array<std::uint8_t, 4>{static_cast<std::uint8_t>(std::lround(255 * share)), 0, 0, 255};
    });
}

/// Collapses edges but those of the rim, down to a share of the triangles or up to an error, which is a share of the
/// mesh's size.
std::vector<std::uint32_t> coarser(const std::vector<std::uint32_t>& indices,
                                   const std::vector<Mesh::Float3>& positions, const Coarseness& to) {
  std::vector<std::uint32_t> fewer(indices.size());
  const auto target = static_cast<std::size_t>(to.share * static_cast<double>(indices.size() / 3)) * 3;
  fewer.resize(meshopt_simplify(fewer.data(), indices.data(), indices.size(), &positions.front().x, positions.size(),
                                sizeof(Mesh::Float3), target, to.max_error, meshopt_SimplifyLockBorder, nullptr));
  meshopt_optimizeVertexCache(fewer.data(), fewer.data(), fewer.size(), positions.size());
  return fewer;
}

}  // namespace

PackedMesh pack_mesh(const Mesh& mesh, const std::vector<double>& errors, double error_range,
                     std::size_t triangle_budget) {
  PackedMesh packed;
  if (mesh.positions.empty()) return packed;
  std::vector<std::uint32_t> indices = decimated(mesh, triangle_budget);
  const std::vector<std::uint32_t> source =
      indices.empty() ? thinned(mesh.positions.size()) : order(&indices, mesh.positions.size());
  packed.vertices = source.size();
  packed.triangles = indices.size() / 3;
  pack_positions(mesh, source, grid_around(mesh, source), &packed);
  packed.indices = encoded_indices(indices, source.size());
  pack_attributes(mesh, errors, error_range, source, &packed);
  return packed;
}

PackedMesh pack_levels(const Mesh& mesh, const std::vector<double>& errors, double error_range, const MeshGrid& grid) {
  PackedMesh packed;
  if (mesh.triangles.empty()) return packed;
  std::vector<std::uint32_t> indices = indices_of(mesh);
  const std::vector<std::uint32_t> source = order(&indices, mesh.positions.size());
  std::vector<Mesh::Float3> positions;
  positions.reserve(source.size());
  for (const std::uint32_t i : source) positions.push_back(mesh.positions[i]);
  packed.vertices = source.size();
  packed.triangles = indices.size() / 3;
  const auto add_level = [&] {
    packed.level_triangles.push_back(indices.size() / 3);
    packed.level_indices.push_back(encoded_indices(indices, source.size()));
  };
  add_level();
  for (const Coarseness& to : kLevels) {
    indices = coarser(indices, positions, to);
    add_level();
  }
  pack_positions(mesh, source, grid, &packed);
  pack_attributes(mesh, errors, error_range, source, &packed);
  return packed;
}

}  // namespace plumbline::app
