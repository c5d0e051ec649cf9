// A mesh made small enough for a page: decimated, quantised, and packed by meshoptimizer's codecs.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "plumbline/mesh.h"

namespace plumbline::app {

/// What a page takes: half a million triangles are 3 to 5 MB in it and turn smoothly on a laptop.
constexpr std::size_t kTriangleBudget = 500'000;
constexpr std::size_t kPointBudget = 1'000'000;  ///< of a mesh without triangles

/// Buffers as meshopt_encodeVertexBuffer and meshopt_encodeIndexBuffer leave them; an absent attribute is empty.
struct PackedMesh {
  std::size_t vertices = 0, triangles = 0;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< metres
  double step = 0;                                   ///< metres: position = origin + step * integers
  std::string positions;                             ///< 4 uint16 a vertex: x, y, z, 0
  std::string normals;                               ///< 4 int8 a vertex, 127 = 1
  std::string colors;                                ///< 4 uint8 a vertex: r, g, b, 255
  std::string errors;                                ///< 4 uint8 a vertex: error, 0, 0, 255; 255 = `error_range`
  std::string indices;                               ///< uint32; empty for a cloud of points
  /// Of `pack_levels`, the finest first: triangles and their indices, as `indices`.
  std::vector<std::size_t> level_triangles;
  std::vector<std::string> level_indices;
};

/// What positions are counted in.
struct MeshGrid {
  Eigen::Vector3d origin;  ///< metres
  double step;             ///< metres; the grid is 65536 steps wide
};

/// `errors`: one a vertex, metres, or none. Coordinates that are not finite are taken for zero.
PackedMesh pack_mesh(const Mesh& mesh, const std::vector<double>& errors = {}, double error_range = 1,
                     std::size_t triangle_budget = kTriangleBudget);

/// With all triangles, and with ever fewer: three levels that share their vertices, and the rim, so that neighbours
/// meet without a gap. Only the coarsest leaves gaps where it must. The mesh must have triangles, or nothing at all.
PackedMesh pack_levels(const Mesh& mesh, const std::vector<double>& errors, double error_range, const MeshGrid& grid);

}  // namespace plumbline::app
