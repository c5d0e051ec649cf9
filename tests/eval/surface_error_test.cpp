#include "plumbline/surface_error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "plumbline/error.h"
#include "plumbline/frame.h"
#include "plumbline/image.h"
#include "plumbline/mesh.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"

namespace plumbline::eval {
namespace {

using Eigen::Vector3d;

Vector3d to_vector(const Mesh::Float3& p) {
  return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}

Mesh::Float3 to_float(const Vector3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

/// The square [−half, half]² at the given height.
Mesh square(float half, float z) {
  Mesh mesh;
  mesh.positions = {{-half, -half, z}, {half, -half, z}, {half, half, z}, {-half, half, z}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

Mesh uv_sphere(double radius, int rings) {
  Mesh mesh;
  const int columns = 2 * rings;
  for (int i = 0; i <= rings; ++i) {
    for (int j = 0; j < columns; ++j) {
      const double polar = std::numbers::pi * i / rings, azimuth = 2 * std::numbers::pi * j / columns;
      mesh.positions.push_back(to_float(radius * Vector3d(std::sin(polar) * std::cos(azimuth),
                                                          std::sin(polar) * std::sin(azimuth), std::cos(polar))));
    }
  }
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * columns + j % columns); };
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < columns; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

PointCloud random_points(std::size_t count, double half, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<float> uniform(static_cast<float>(-half), static_cast<float>(half));
  PointCloud points;
  for (std::size_t i = 0; i < count; ++i) points.push_back({uniform(random), uniform(random), uniform(random)});
  return points;
}

TEST(DistancesToMesh, SquareInClosedForm) {
  const Mesh reference = square(1, 0.5f);
  const PointCloud points = random_points(20000, 3, 1);
  const std::vector<double> distances = distances_to_mesh(points, reference);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d p = to_vector(points[i]);
    const Vector3d excess(std::max(0.0, std::abs(p.x()) - 1), std::max(0.0, std::abs(p.y()) - 1), p.z() - 0.5);
    EXPECT_NEAR(distances[i], excess.norm(), 1e-6 * (1 + excess.norm()));
  }
}

TEST(DistancesToMesh, IsTheLeastOverAllTrianglesWhateverTheyAre) {
  Mesh soup;
  soup.positions = random_points(90, 2, 2);
  for (std::uint32_t i = 0; i < 30; ++i) soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  soup.triangles.push_back({0, 0, 5});  // a segment
  soup.triangles.push_back({7, 7, 7});  // a point
  const PointCloud points = random_points(300, 3, 3);
  const std::vector<double> distances = distances_to_mesh(points, soup);
  // Brute force: the least over a dense grid of barycentric coordinates is not below the distance, nor far above it.
  constexpr int kGrid = 60;
  for (std::size_t i = 0; i < points.size(); i += 10) {
    double least = std::numeric_limits<double>::infinity();
    for (const Mesh::Triangle& t : soup.triangles) {
      const Vector3d a = to_vector(soup.positions[t.a]), b = to_vector(soup.positions[t.b]),
                     c = to_vector(soup.positions[t.c]);
      for (int u = 0; u <= kGrid; ++u) {
        for (int v = 0; u + v <= kGrid; ++v) {
          const Vector3d on = a + (b - a) * u / kGrid + (c - a) * v / kGrid;
          least = std::min(least, (on - to_vector(points[i])).norm());
        }
      }
    }
    EXPECT_LE(distances[i], least + 1e-6);
    EXPECT_GT(distances[i], least - 0.06);
  }
}

TEST(DistancesToMesh, ConcentricSpheres) {
  const PointCloud points = sample_surface(uv_sphere(1.1, 200), 20000);
  const Statistics s = statistics(distances_to_mesh(points, uv_sphere(1, 200)));
  // The facets' sagitta: 1 − cos(π/400) ≈ 3e-5 for either.
  EXPECT_NEAR(s.mean, 0.1, 1e-4);
  EXPECT_NEAR(s.rmse, 0.1, 1e-4);
  EXPECT_NEAR(s.median, 0.1, 1e-4);
  EXPECT_NEAR(s.min, 0.1, 2e-4);
  EXPECT_NEAR(s.max, 0.1, 2e-4);
}

TEST(DistancesToMesh, FarAwayCoordinatesKeepTheirPrecision) {
  Mesh mesh = square(1, 0);
  for (Mesh::Float3& p : mesh.positions) p.x += 1000;
  const std::vector<Mesh::Float3> points = {{1000.25f, 0.5f, 0.001f}, {1000.25f, 0.5f, 3}};
  const std::vector<double> distances = distances_to_mesh(points, mesh);
  EXPECT_NEAR(distances[0], 0.001, 1e-8);
  EXPECT_NEAR(distances[1], 3, 1e-8);
}

TEST(DistancesToPoints, IsTheNearestNeighbour) {
  const PointCloud reference = random_points(700, 1, 4), points = random_points(300, 1.5, 5);
  const std::vector<double> distances = distances_to_points(points, reference);
  for (std::size_t i = 0; i < points.size(); ++i) {
    double least = std::numeric_limits<double>::infinity();
    for (const Mesh::Float3& r : reference) least = std::min(least, (to_vector(r) - to_vector(points[i])).norm());
    EXPECT_NEAR(distances[i], least, 1e-12);
  }
}

TEST(DistancesToPoints, OneReferencePointAndManyEqualOnes) {
  EXPECT_NEAR(distances_to_points(PointCloud{{3, 4, 0}}, PointCloud{{0, 0, 0}})[0], 5, 1e-12);
  EXPECT_NEAR(distances_to_points(PointCloud{{3, 4, 0}}, PointCloud(1000, {0, 0, 0}))[0], 5, 1e-12);
}

TEST(SampleSurface, IsUniformByAreaAndRepeats) {
  Mesh mesh = square(1, 0);            // 4 m² in two triangles
  const Mesh small = square(0.5f, 2);  // and 1 m² in two more
  mesh.positions.insert(mesh.positions.end(), small.positions.begin(), small.positions.end());
  mesh.triangles.push_back({4, 5, 6});
  mesh.triangles.push_back({4, 6, 7});
  const PointCloud points = sample_surface(mesh, 50000, 9);
  ASSERT_EQ(points.size(), 50000U);
  double upper = 0, quadrant = 0, square_of_x = 0;
  for (const Mesh::Float3& p : points) {
    if (p.z > 1) {
      ++upper;
      continue;
    }
    EXPECT_EQ(p.z, 0);
    quadrant += p.x > 0.5f && p.y > 0.5f;
    square_of_x += static_cast<double>(p.x * p.x);
  }
  EXPECT_NEAR(upper / 50000, 0.2, 0.001);
  EXPECT_NEAR(quadrant / 40000, 1.0 / 16, 0.006);
  EXPECT_NEAR(square_of_x / 40000, 1.0 / 3, 0.006);
  const PointCloud again = sample_surface(mesh, 50000, 9), other = sample_surface(mesh, 50000, 10);
  EXPECT_TRUE(std::equal(points.begin(), points.end(), again.begin(),
                         [](const auto& a, const auto& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }));
  EXPECT_NE(points[100].x, other[100].x);
}

TEST(SurfaceError, ScoresCountWhatLiesWithinTheThreshold) {
  const std::vector<double> forth = {0.001, 0.002, 0.003, 0.02}, back = {0.001, 0.01, 0.02, 0.03};
  const std::vector<double> thresholds = {0.003, 0.0005, 1};
  const SurfaceError error = surface_error(forth, back, thresholds);
  EXPECT_DOUBLE_EQ(error.scores[0].precision, 0.75);
  EXPECT_DOUBLE_EQ(error.scores[0].recall, 0.25);
  EXPECT_DOUBLE_EQ(error.scores[0].f_score, 0.375);
  EXPECT_EQ(error.scores[1].f_score, 0);
  EXPECT_EQ(error.scores[2].f_score, 1);
  EXPECT_NEAR(error.accuracy.mean, 0.0065, 1e-15);
  EXPECT_NEAR(error.accuracy.median, 0.0025, 1e-15);
  EXPECT_NEAR(error.completeness.max, 0.03, 1e-15);
}

TEST(SurfaceError, HalfOfASurfaceIsAccurateButIncomplete) {
  Mesh half = square(1, 0.004f);
  for (Mesh::Float3& p : half.positions) p.x = std::min(p.x, 0.0f);
  const std::vector<double> thresholds = {0.005};
  const SurfaceError error = compare_meshes(half, square(1, 0), thresholds, 20000);
  EXPECT_NEAR(error.accuracy.max, 0.004, 1e-6);
  EXPECT_EQ(error.scores[0].precision, 1);
  EXPECT_NEAR(error.scores[0].recall, 0.5015, 0.005);  // with the rim that is within √(5² − 4²) = 3 mm
  EXPECT_NEAR(error.completeness.mean, 0.25, 0.01);
}

TEST(SurfaceError, OfPointClouds) {
  const PointCloud a = random_points(500, 1, 6);
  PointCloud b = a;
  for (Mesh::Float3& p : b) p.z += 1e-4f;
  const std::vector<double> thresholds = {1e-3};
  const SurfaceError error = compare_points(a, b, thresholds);
  EXPECT_NEAR(error.accuracy.max, 1e-4, 1e-6);
  EXPECT_EQ(error.scores[0].f_score, 1);
}

TEST(BackProject, PutsReadingsOnThePlaneTheyCameFrom) {
  const Pinhole camera{50, -60, 15.5f, 11.5f, 32, 24};
  const SE3 world_from_camera(so3::exp({0.3, -0.2, 0.9}), {1, 2, 3});
  Frame frame;
  frame.depth_scale = 1000;
  frame.depth = DepthImage(32, 24);
  for (std::uint16_t& reading : frame.depth.pixels) reading = 1500;
  frame.depth.at(3, 4) = 0;
  const PointCloud points = back_project(frame, camera, world_from_camera);
  ASSERT_EQ(points.size(), 32U * 24U - 1);
  for (const Mesh::Float3& p : points) {
    const Vector3d local = world_from_camera.inverse() * to_vector(p);
    EXPECT_NEAR(local.z(), 1.5, 1e-6);
    const double u = local.x() / local.z() * 50 + 15.5, v = local.y() / local.z() * -60 + 11.5;
    EXPECT_NEAR(u, std::round(u), 1e-4);
    EXPECT_NEAR(v, std::round(v), 1e-4);
  }
  EXPECT_EQ(back_project(frame, camera, world_from_camera, 4).size(), 8U * 6U);
  EXPECT_THROW(back_project(frame, Pinhole{50, 60, 0, 0, 31, 24}, SE3()), Error);
}

TEST(SurfaceErrors, BadInputIsRefused) {
  const PointCloud one = {{0, 0, 0}}, bad = {{0, std::numeric_limits<float>::quiet_NaN(), 0}};
  EXPECT_THROW(distances_to_points(one, {}), Error);
  EXPECT_THROW(distances_to_points(bad, one), Error);
  EXPECT_THROW(distances_to_points(one, bad), Error);
  EXPECT_THROW(distances_to_mesh(one, Mesh{}), Error);
  EXPECT_THROW(distances_to_mesh(bad, square(1, 0)), Error);
  Mesh broken = square(1, 0);
  broken.triangles.push_back({0, 1, 9});
  EXPECT_THROW(distances_to_mesh(one, broken), Error);
  EXPECT_THROW(sample_surface(broken, 10), Error);
  EXPECT_THROW(sample_surface(square(0, 0), 10), Error);
  const std::vector<double> some = {1.0}, none, zero = {0.0};
  EXPECT_THROW(surface_error(some, none, some), Error);
  EXPECT_THROW(surface_error(some, some, zero), Error);
}

TEST(Statistics, OfKnownValues) {
  const std::vector<double> values = {4, 1, 3, 2};
  const Statistics s = statistics(values);
  EXPECT_EQ(s.count, 4U);
  EXPECT_DOUBLE_EQ(s.mean, 2.5);
  EXPECT_DOUBLE_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(7.5));
  EXPECT_DOUBLE_EQ(s.std, std::sqrt(1.25));
  EXPECT_EQ(s.min, 1);
  EXPECT_EQ(s.max, 4);
  EXPECT_EQ(statistics(std::vector<double>{}).count, 0U);
  EXPECT_EQ(statistics(std::vector<double>{5, 9, 7}).median, 7);
}

}  // namespace
}  // namespace plumbline::eval
