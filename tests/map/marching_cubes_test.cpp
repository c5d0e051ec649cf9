// The derived table by its properties, and the meshes of fields whose surface is known or whose topology must hold for
// any field.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "map/reference_volume.h"
#include "map/volume.h"
#include "plumbline/angles.h"
#include "plumbline/image.h"
#include "plumbline/mesh.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "support/lane_types.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

using kernels::CellTriangles;
using kernels::edge_corner;
using kernels::kCellTable;

// ---- the table ------------------------------------------------------------------------------------------------------

bool is_inside(int pattern, int corner) { return (pattern >> corner & 1) != 0; }

bool is_crossed(int pattern, int edge) {
  const int low = edge_corner(edge), high = low | 1 << (edge / 4);
  return is_inside(pattern, low) != is_inside(pattern, high);
}

/// Directed edges of a pattern's triangles, by cell edge.
std::vector<std::pair<int, int>> half_edges(int pattern) {
  const CellTriangles& cell = kCellTable[static_cast<std::size_t>(pattern)];
  std::vector<std::pair<int, int>> result;
  for (int t = 0; t < cell.count; ++t) {
    for (int k = 0; k < 3; ++k)
      result.emplace_back(cell.edges[static_cast<std::size_t>(3 * t + k)],
                          cell.edges[static_cast<std::size_t>(3 * t + (k + 1) % 3)]);
  }
  return result;
}

/// Those without an opposite: the surface's outline on the cell's faces.
std::set<std::pair<int, int>> outline(int pattern) {
  const auto all = half_edges(pattern);
  std::set<std::pair<int, int>> result(all.begin(), all.end());
  for (const auto& [a, b] : all) {
    if (result.contains({b, a})) {
      result.erase({a, b});
      result.erase({b, a});
    }
  }
  return result;
}

/// Whether a cell edge lies on the face 2·axis + side.
bool lies_on(int edge, int axis, int side) { return edge / 4 != axis && (edge_corner(edge) >> axis & 1) == side; }

/// Faces with two diagonal corners inside.
bool is_ambiguous(int pattern) {
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      const int p = 1 << (axis + 1) % 3, q = 1 << (axis + 2) % 3, base = side << axis;
      const bool a = is_inside(pattern, base), b = is_inside(pattern, base | p), c = is_inside(pattern, base | p | q),
                 d = is_inside(pattern, base | q);
      if (a == c && b == d && a != b) return true;
    }
  }
  return false;
}

Eigen::Vector3d corner_position(int corner) { return Eigen::Vector3d(corner & 1, corner >> 1 & 1, corner >> 2); }

Eigen::Vector3d edge_middle(int edge) {
  return corner_position(edge_corner(edge)) + 0.5 * Eigen::Vector3d::Unit(edge / 4);
}

TEST(CellTable, UsesExactlyTheCrossedEdges) {
  for (int pattern = 0; pattern < 256; ++pattern) {
    std::set<int> used, crossed;
    for (const auto& [a, b] : half_edges(pattern)) used.insert(a);
    for (int edge = 0; edge < kernels::kCellEdges; ++edge) {
      if (is_crossed(pattern, edge)) crossed.insert(edge);
    }
    EXPECT_EQ(used, crossed) << pattern;
    EXPECT_LE(kCellTable[static_cast<std::size_t>(pattern)].count, kernels::kMaxTriangles);
  }
  EXPECT_EQ(kCellTable[0].count, 0);
  EXPECT_EQ(kCellTable[255].count, 0);
}

TEST(CellTable, OutlinesAreClosedLoopsOnTheFaces) {
  for (int pattern = 0; pattern < 256; ++pattern) {
    const auto all = half_edges(pattern);
    EXPECT_EQ(std::set(all.begin(), all.end()).size(), all.size()) << "an edge twice in one direction, " << pattern;
    std::map<int, int> leaving, arriving;
    for (const auto& [a, b] : outline(pattern)) {
      ++leaving[a];
      ++arriving[b];
      int faces = 0;
      for (int face = 0; face < 6; ++face) faces += lies_on(a, face / 2, face % 2) && lies_on(b, face / 2, face % 2);
      EXPECT_EQ(faces, 1) << "an outline runs through the inside of cell " << pattern;
    }
    for (int edge = 0; edge < kernels::kCellEdges; ++edge) {
      EXPECT_EQ(leaving[edge], is_crossed(pattern, edge)) << pattern;
      EXPECT_EQ(arriving[edge], is_crossed(pattern, edge)) << pattern;
    }
  }
}

TEST(CellTable, NeighboursAgreeOnTheirCommonFace) {
  // Every pair of cells with the same four corners between them: what one draws, the other draws backwards.
  for (int axis = 0; axis < 3; ++axis) {
    for (int low = 0; low < 256; ++low) {
      std::set<std::pair<int, int>> drawn;
      for (const auto& [a, b] : outline(low)) {
        if (lies_on(a, axis, 1) && lies_on(b, axis, 1)) drawn.insert({b, a});
      }
      for (int free_corners = 0; free_corners < 16; ++free_corners) {
        int high = 0, next = 0;
        for (int corner = 0; corner < 8; ++corner) {
          const bool shared = (corner >> axis & 1) == 0;
          const bool inside = shared ? is_inside(low, corner | 1 << axis) : is_inside(free_corners, next++);
          high |= static_cast<int>(inside) << corner;
        }
        std::set<std::pair<int, int>> seen;
        const auto across = [&](int edge) {  // the same edge as the lower cell numbers it
          for (int other = edge / 4 * 4; other < edge / 4 * 4 + 4; ++other) {
            if (edge_corner(other) == (edge_corner(edge) | 1 << axis)) return other;
          }
          return -1;
        };
        for (const auto& [a, b] : outline(high)) {
          if (lies_on(a, axis, 0) && lies_on(b, axis, 0)) seen.insert({across(a), across(b)});
        }
        ASSERT_EQ(drawn, seen) << "cells " << low << " and " << high << " along axis " << axis;
      }
    }
  }
}

TEST(CellTable, ComplementsHaveTheSameSurfaceTurnedRound) {
  int unambiguous = 0;
  for (int pattern = 0; pattern < 256; ++pattern) {
    if (is_ambiguous(pattern)) continue;
    ++unambiguous;
    const auto mine = outline(pattern), other = outline(255 - pattern);
    EXPECT_EQ(kCellTable[static_cast<std::size_t>(pattern)].count,
              kCellTable[static_cast<std::size_t>(255 - pattern)].count);
    for (const auto& [a, b] : mine) EXPECT_TRUE(other.contains({b, a})) << pattern;
  }
  EXPECT_EQ(unambiguous, 136);
}

TEST(CellTable, TrianglesFaceTheFreeSide) {
  for (int corner = 0; corner < 8; ++corner) {
    const CellTriangles& cell = kCellTable[std::size_t{1} << corner];
    ASSERT_EQ(cell.count, 1);
    const Eigen::Vector3d a = edge_middle(cell.edges[0]), b = edge_middle(cell.edges[1]),
                          c = edge_middle(cell.edges[2]);
    const Eigen::Vector3d outward = (a + b + c) / 3 - corner_position(corner);
    EXPECT_GT((b - a).cross(c - a).dot(outward), 0) << "corner " << corner;
  }
}

// ---- meshes ---------------------------------------------------------------------------------------------------------

Eigen::Vector3d vec(const Mesh::Float3& p) { return {double{p.x}, double{p.y}, double{p.z}}; }

struct Corners {
  Eigen::Vector3d a, b, c;
  Eigen::Vector3d area_vector() const { return 0.5 * (b - a).cross(c - a); }
};

Corners corners(const Mesh& mesh, const Mesh::Triangle& t) {
  return {vec(mesh.positions[t.a]), vec(mesh.positions[t.b]), vec(mesh.positions[t.c])};
}

using EdgeCounts = std::map<std::pair<std::uint32_t, std::uint32_t>, int>;

EdgeCounts directed_edges(const Mesh& mesh) {
  EdgeCounts counts;
  for (const Mesh::Triangle& t : mesh.triangles) {
    ++counts[{t.a, t.b}];
    ++counts[{t.b, t.c}];
    ++counts[{t.c, t.a}];
  }
  return counts;
}

void expect_sound(const Mesh& mesh) {
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  ASSERT_TRUE(mesh.colors.empty() || mesh.colors.size() == mesh.positions.size());
  std::vector<bool> used(mesh.positions.size(), false);
  for (const Mesh::Triangle& t : mesh.triangles) {
    ASSERT_LT(std::max({t.a, t.b, t.c}), mesh.positions.size());
    used[t.a] = used[t.b] = used[t.c] = true;
  }
  EXPECT_EQ(std::count(used.begin(), used.end(), false), 0) << "vertices that no triangle uses";
  for (const Mesh::Float3& n : mesh.normals) ASSERT_NEAR(vec(n).norm(), 1, 1e-5);
}

class MeshTest : public test::LaneTest {
 protected:
  Volume make_volume(int resolution, double side, double truncation, bool color = false) const {
    VolumeParameters parameters = preset("kinectfusion").volume;
    parameters.resolution = resolution;
    parameters.truncation = truncation;
    Volume volume(parameters, test::pinhole(160, 120), backend(), color);
    volume.place({SE3(), side});
    return volume;
  }
};

struct SphereCase {
  Eigen::Vector3d centre{0.52, 0.47, 0.5};
  double radius = 0.33;
  double distance(const Eigen::Vector3d& p) const { return (p - centre).norm() - radius; }
};

TEST_P(MeshTest, ASphereIsAClosedManifold) {
  const SphereCase sphere;
  const Volume volume = make_volume(64, 1, 0.06);
  test::write_distance(volume.view(), [&](const Eigen::Vector3d& p) { return sphere.distance(p); });
  const Mesh mesh = volume.extract_mesh(MeshParameters());
  expect_sound(mesh);
  ASSERT_GT(mesh.triangles.size(), 5000u);
  const EdgeCounts edges = directed_edges(mesh);
  for (const auto& [edge, count] : edges) {
    ASSERT_EQ(count, 1);
    ASSERT_TRUE(edges.contains({edge.second, edge.first})) << "a hole";
  }
  const auto v = static_cast<long>(mesh.positions.size()), e = static_cast<long>(edges.size() / 2),
             f = static_cast<long>(mesh.triangles.size());
  EXPECT_EQ(v - e + f, 2) << "Euler's characteristic of a sphere";
}

TEST_P(MeshTest, ASphereHasItsShape) {
  const SphereCase sphere;
  Volume volume = make_volume(64, 1, 0.06);
  const SE3 pose = test::Random(8).motion(0.9, 1.5);
  volume.place({pose, 1});
  test::write_distance(volume.view(), [&](const Eigen::Vector3d& p) { return sphere.distance(p); });
  const Mesh mesh = volume.extract_mesh(MeshParameters());
  expect_sound(mesh);
  const Eigen::Vector3d centre = pose * sphere.centre;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Eigen::Vector3d out = vec(mesh.positions[i]) - centre;
    ASSERT_NEAR(out.norm(), sphere.radius, 0.1 / 64);
    ASSERT_LT(test::angle_between(out, vec(mesh.normals[i])), 1 * kRadiansPerDegree);
  }
  double volume_inside = 0, area = 0;
  for (const Mesh::Triangle& t : mesh.triangles) {
    const Corners c = corners(mesh, t);
    const Eigen::Vector3d middle = (c.a + c.b + c.c) / 3 - centre;
    ASSERT_GT(c.area_vector().dot(middle), 0) << "it winds the wrong way";
    volume_inside += c.area_vector().dot(middle) / 3;
    area += c.area_vector().norm();
  }
  const double pi = std::numbers::pi, r = sphere.radius;
  EXPECT_NEAR(volume_inside, 4.0 / 3 * pi * r * r * r, 0.01 * 4.0 / 3 * pi * r * r * r);
  EXPECT_NEAR(area, 4 * pi * r * r, 0.01 * 4 * pi * r * r);
}

/// Distances at random, with exact zeros and full truncation among them.
void write_random(const kernels::BrickMap& view, unsigned seed, double unseen) {
  test::Random random(seed);
  test::write_distance(view, [&](const Eigen::Vector3d&) {
    const int kind = random.integer(0, 20);
    return kind == 0 ? 0.0 : (kind == 1 ? -1.0 : random.uniform(-1, 1)) * double{view.truncation};
  });
  if (unseen == 0) return;
  for (int z = 0; z < view.resolution(); ++z) {
    for (int y = 0; y < view.resolution(); ++y) {
      for (int x = 0; x < view.resolution(); ++x) {
        if (random.uniform(0, 1) < unseen) view.voxel(view.find({x, y, z})) = 0;
      }
    }
  }
}

TEST_P(MeshTest, AnyFieldIsClosedWithinTheVolume) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const Volume volume = make_volume(24, 24, 3);  // voxels of one metre
    write_random(volume.view(), seed, 0);
    const Mesh mesh = volume.extract_mesh(MeshParameters());
    expect_sound(mesh);
    ASSERT_GT(mesh.triangles.size(), 20000u);
    const auto on_border = [&](std::uint32_t vertex) {
      const Eigen::Vector3d p = vec(mesh.positions[vertex]);
      return p.minCoeff() < 0.5 + 1e-5 || p.maxCoeff() > 23.5 - 1e-5;
    };
    const EdgeCounts edges = directed_edges(mesh);
    int open = 0;
    for (const auto& [edge, count] : edges) {
      const auto opposite = edges.find({edge.second, edge.first});
      if (opposite != edges.end() && opposite->second == count) continue;
      ++open;
      ASSERT_TRUE(on_border(edge.first) && on_border(edge.second)) << "a crack inside the volume";
    }
    EXPECT_GT(open, 100) << "the border's outline";
  }
}

TEST_P(MeshTest, NoTriangleIsDegenerate) {
  const Volume volume = make_volume(24, 24, 3);
  write_random(volume.view(), 4, 0);
  const Mesh mesh = volume.extract_mesh(MeshParameters());
  std::set<std::array<float, 3>> places;
  for (const Mesh::Float3& p : mesh.positions) places.insert({p.x, p.y, p.z});
  EXPECT_EQ(places.size(), mesh.positions.size()) << "two vertices in one place";
  for (const Mesh::Triangle& t : mesh.triangles) {
    ASSERT_TRUE(t.a != t.b && t.b != t.c && t.c != t.a);
    ASSERT_GT(corners(mesh, t).area_vector().norm(), 1e-8) << "square voxels";
  }
}

TEST_P(MeshTest, CellsThatWereNotWhollySeenAreLeftOut) {
  const Volume volume = make_volume(24, 24, 3);
  write_random(volume.view(), 5, 0.1);
  const Mesh mesh = volume.extract_mesh(MeshParameters());
  expect_sound(mesh);
  ASSERT_GT(mesh.triangles.size(), 1000u);
  for (const Mesh::Triangle& t : mesh.triangles) {
    const Corners c = corners(mesh, t);
    const Eigen::Vector3d low = ((c.a + c.b + c.c) / 3 - Eigen::Vector3d::Constant(0.5)).array().floor();
    for (int k = 0; k < 8; ++k) {
      const Eigen::Vector3d corner = low + corner_position(k);
      // A triangle within a face belongs to either cell; its mean may be rounded into the other.
      if (((c.a + c.b + c.c) / 3 - Eigen::Vector3d::Constant(0.5) - low).minCoeff() < 1e-4) continue;
      ASSERT_GT(test::voxel_at(volume.view(), static_cast<int>(corner.x()), static_cast<int>(corner.y()),
                               static_cast<int>(corner.z()))
                    .weight,
                0);
    }
  }
}

TEST_P(MeshTest, NothingGivesAnEmptyMesh) {
  const Volume volume = make_volume(64, 1, 0.06);
  const Mesh mesh = volume.extract_mesh(MeshParameters());
  EXPECT_TRUE(mesh.positions.empty());
  EXPECT_TRUE(mesh.triangles.empty());
  test::write_distance(volume.view(), [](const Eigen::Vector3d&) { return 1.0; });
  EXPECT_TRUE(volume.extract_mesh(MeshParameters()).triangles.empty()) << "free space only";
}

TEST_P(MeshTest, SurfacesSeenTooSeldomAreLeftOut) {
  const Pinhole camera = test::pinhole(160, 120);
  Volume volume = make_volume(64, 1, 0.06);
  const auto wall = [&](int columns) {
    Image<float> depth(camera.width, camera.height);
    for (int y = 0; y < depth.height; ++y) std::fill(depth.row(y), depth.row(y) + columns, 1.2f);
    return test::to_plane(backend(), depth);
  };
  const SE3 pose(Eigen::Matrix3d::Identity(), {0.5, 0.5, -0.7});
  volume.integrate(wall(160), nullptr, camera, pose);
  MeshParameters parameters;
  parameters.min_weight = 3;
  const std::size_t all = volume.extract_mesh(parameters).triangles.size();
  EXPECT_GT(all, 1000u) << "never more than the frames fused are asked for";
  for (int i = 0; i < 3; ++i) volume.integrate(wall(80), nullptr, camera, pose);
  const Mesh mesh = volume.extract_mesh(parameters);
  EXPECT_NEAR(static_cast<double>(mesh.triangles.size()), 0.5 * static_cast<double>(all),
              0.05 * static_cast<double>(all));
  for (const Mesh::Float3& p : mesh.positions) ASSERT_LT(p.x, 0.5) << "the part seen once";
  parameters.min_weight = 1;
  EXPECT_EQ(volume.extract_mesh(parameters).triangles.size(), all);
}

TEST_P(MeshTest, NoMoreWeightIsAskedForThanAVoxelCanHave) {
  const Pinhole camera = test::pinhole(160, 120);
  VolumeParameters parameters = preset("kinectfusion").volume;
  parameters.resolution = 64;
  parameters.truncation = 0.06;
  parameters.max_weight = 2;
  Volume volume(parameters, camera, backend(), false);
  volume.place({SE3(), 1});
  Image<float> wall(camera.width, camera.height);
  std::fill(wall.pixels.begin(), wall.pixels.end(), 1.2f);
  const SE3 pose(Eigen::Matrix3d::Identity(), {0.5, 0.5, -0.7});
  for (int i = 0; i < 5; ++i) volume.integrate(test::to_plane(backend(), wall), nullptr, camera, pose);
  MeshParameters mesh;
  mesh.min_weight = 3;
  EXPECT_GT(volume.extract_mesh(mesh).triangles.size(), 1000u);
}

TEST_P(MeshTest, VolumesSideBySideKeepApartInShapeAndColour) {
  // Two walls in two volumes of one backend, one coloured along x, the other in one colour.
  const Volume first = make_volume(24, 24, 3, true), second = make_volume(16, 16, 3, true);
  test::write_distance(first.view(), [](const Eigen::Vector3d& p) { return p.z() - 11.8; });
  test::write_distance(second.view(), [](const Eigen::Vector3d& p) { return 5.3 - p.x(); });
  const auto paint = [](const kernels::BrickMap& view, const auto& red_at) {
    for (int z = 0; z < view.resolution(); ++z) {
      for (int y = 0; y < view.resolution(); ++y) {
        for (int x = 0; x < view.resolution(); ++x)
          view.color(view.find({x, y, z})) = red_at(x, z) | 40 << 8 | 200 << 16 | 1 << 24;
      }
    }
  };
  paint(first.view(), [](int x, int z) { return 10 * x + (z == 11 ? 0 : 10); });
  paint(second.view(), [](int, int) { return 77; });
  for (int repetition = 0; repetition < 2; ++repetition) {
    const Mesh a = first.extract_mesh(MeshParameters()), b = second.extract_mesh(MeshParameters());
    expect_sound(a);
    expect_sound(b);
    ASSERT_EQ(a.colors.size(), a.positions.size());
    EXPECT_EQ(a.positions.size(), 24u * 24u);
    EXPECT_EQ(a.triangles.size(), 2u * 23u * 23u);
    for (std::size_t i = 0; i < a.positions.size(); ++i) {
      ASSERT_NEAR(a.positions[i].z, 11.8f, 1e-3f);
      ASSERT_GT(a.normals[i].z, 0.999f);
      // Between the voxels at 11.5 and 12.5, 0.3 of the way: their colours are 10 apart.
      ASSERT_NEAR(a.colors[i].r, 10 * (a.positions[i].x - 0.5f) + 3, 0.6f);
      ASSERT_EQ(a.colors[i].g, 40);
      ASSERT_EQ(a.colors[i].b, 200);
    }
    EXPECT_EQ(b.positions.size(), 16u * 16u);
    for (std::size_t i = 0; i < b.positions.size(); ++i) {
      ASSERT_NEAR(b.positions[i].x, 5.3f, 1e-3f);
      ASSERT_LT(b.normals[i].x, -0.999f);
      ASSERT_EQ(b.colors[i].r, 77);
    }
  }
}

TEST_P(MeshTest, TheColourOfASeenNeighbourStandsForTheOther) {
  const Volume volume = make_volume(16, 16, 3, true);
  test::write_distance(volume.view(), [](const Eigen::Vector3d& p) { return p.z() - 7.9; });
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 8; ++x) volume.view().color(volume.view().find({x, y, 7})) = 90 | 1 << 24;
  }
  const Mesh mesh = volume.extract_mesh(MeshParameters());
  ASSERT_EQ(mesh.colors.size(), 256u);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const bool seen = mesh.positions[i].x < 8;
    ASSERT_EQ(mesh.colors[i].r, seen ? 90 : 128);
    ASSERT_EQ(mesh.colors[i].g, seen ? 0 : 128) << "grey where no colour was seen";
  }
}

PLUMBLINE_ON_EVERY_LANE_TYPE(MeshTest);

}  // namespace
}  // namespace plumbline
