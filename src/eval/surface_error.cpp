#include "plumbline/surface_error.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nanoflann.hpp>
#include <random>
#include <string>

#include "core/embree_scene.h"
#include "core/random.h"
#include "plumbline/error.h"
#include "plumbline/mesh.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"

namespace plumbline::eval {
namespace {

using Eigen::Vector3d;

constexpr const char* kSurfaceErrorWhere = "surface evaluation";
constexpr std::size_t kGrain = 1024;  ///< points a task; one query is a few microseconds

Vector3d to_vector(const Mesh::Float3& p) { return {p.x, p.y, p.z}; }

Mesh::Float3 to_point(const Vector3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

void check_finite(std::span<const Mesh::Float3> points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (to_vector(points[i]).allFinite()) continue;
    throw Error("point " + std::to_string(i) + " is not finite", kSurfaceErrorWhere, "remove it");
  }
}

struct TriangleCorners {
  Vector3d a, b, c;

  TriangleCorners(const Mesh& mesh, std::size_t index)
      : a(to_vector(mesh.positions[mesh.triangles[index].a])),
        b(to_vector(mesh.positions[mesh.triangles[index].b])),
        c(to_vector(mesh.positions[mesh.triangles[index].c])) {}

  double area() const { return (b - a).cross(c - a).norm() / 2; }
};

template <class Distance>
std::vector<double> for_each_point(std::span<const Mesh::Float3> points, const Distance& distance) {
  std::vector<double> distances(points.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size(), kGrain), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) distances[i] = distance(points[i]);
  });
  return distances;
}

/// What nanoflann asks of a point cloud. Doubles keep the differences of the single-precision coordinates exact.
struct CloudAdaptor {
  std::span<const Mesh::Float3> points;

  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t index, std::size_t axis) const {
    const Mesh::Float3& p = points[index];
    return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};
using KdTree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, CloudAdaptor>, CloudAdaptor, 3>;

/// Running sums of the triangles' areas, one per triangle.
std::vector<double> cumulative_areas(const Mesh& mesh) {
  std::vector<double> sums;
  sums.reserve(mesh.triangles.size());
  double sum = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    sum += TriangleCorners(mesh, i).area();
    sums.push_back(sum);
  }
  if (!(sum > 0 && std::isfinite(sum))) {
    throw Error("the mesh has no surface of finite area", kSurfaceErrorWhere,
                "check that it has triangles and finite vertices");
  }
  return sums;
}

double fraction_within(std::span<const double> distances, double threshold) {
  const auto within = std::count_if(distances.begin(), distances.end(), [&](double d) { return d <= threshold; });
  return static_cast<double>(within) / static_cast<double>(distances.size());
}

}  // namespace

PointCloud back_project(const Frame& frame, const Pinhole& camera, const SE3& world_from_camera, int step) {
  if (frame.depth.width != camera.width || frame.depth.height != camera.height || step < 1) {
    throw Error("the depth image is " + std::to_string(frame.depth.width) + "×" + std::to_string(frame.depth.height) +
                    ", the camera " + std::to_string(camera.width) + "×" + std::to_string(camera.height),
                kSurfaceErrorWhere, "give the camera of this image, and a step of 1 or more");
  }
  PointCloud points;
  for (int v = 0; v < camera.height; v += step) {
    for (int u = 0; u < camera.width; u += step) {
      const std::uint16_t reading = frame.depth.at(u, v);
      if (reading == 0) continue;
      const Vector3d ray((u - double{camera.cx}) / camera.fx, (v - double{camera.cy}) / camera.fy, 1);
      const Vector3d point = ray * (reading / frame.depth_scale);
      points.push_back(to_point(world_from_camera * point));
    }
  }
  return points;
}

PointCloud sample_surface(const Mesh& mesh, std::size_t count, std::uint64_t seed) {
  embree::check_indices(mesh, kSurfaceErrorWhere);
  const std::vector<double> areas = cumulative_areas(mesh);
  std::mt19937_64 random(seed);
  PointCloud points;
  points.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    // One sample in each of `count` equal shares of the area: uniform, and evener than independent draws.
    const double at = (static_cast<double>(i) + uniform(&random)) / static_cast<double>(count) * areas.back();
    const auto found = std::upper_bound(areas.begin(), areas.end(), at);
    const auto index = std::min(static_cast<std::size_t>(found - areas.begin()), areas.size() - 1);
    const TriangleCorners t(mesh, index);
    // Osada, Funkhouser, Chazelle, Dobkin, "Shape distributions", 2002, §4.
    const double root = std::sqrt(uniform(&random)), share = uniform(&random);
    points.push_back(to_point((1 - root) * t.a + root * (1 - share) * t.b + root * share * t.c));
  }
  return points;
}

std::vector<double> distances_to_points(std::span<const Mesh::Float3> points, std::span<const Mesh::Float3> reference) {
  if (reference.empty())
    throw Error("the reference has no points", kSurfaceErrorWhere, "give a reference that has some");
  check_finite(points);
  check_finite(reference);
  const CloudAdaptor cloud{reference};
  constexpr std::size_t kLeafSize = 16;
  KdTree tree(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize));
  return for_each_point(points, [&](const Mesh::Float3& p) {
    const double query[3] = {p.x, p.y, p.z};
    std::size_t index = 0;
    double squared = std::numeric_limits<double>::infinity();
    nanoflann::KNNResultSet<double> result(1);
    result.init(&index, &squared);
    tree.findNeighbors(result, query, nanoflann::SearchParams());
    return std::sqrt(squared);
  });
}

std::vector<double> distances_to_mesh(std::span<const Mesh::Float3> points, const Mesh& reference) {
  if (reference.triangles.empty()) {
    throw Error("the reference has no triangles", kSurfaceErrorWhere, "give a mesh, or compare with its points");
  }
  check_finite(points);
  check_finite(reference.positions);
  const embree::Device device = embree::make_device();
  const embree::Scene scene = embree::make_scene(device.get(), reference, kSurfaceErrorWhere);
  return for_each_point(
      points, [&](const Mesh::Float3& p) { return embree::distance_to_mesh(scene.get(), reference, to_vector(p)); });
}

SurfaceError surface_error(std::span<const double> to_reference, std::span<const double> from_reference,
                           std::span<const double> thresholds) {
  if (to_reference.empty() || from_reference.empty()) {
    throw Error("one of the surfaces has no points", kSurfaceErrorWhere, "check that both overlap the region compared");
  }
  SurfaceError error{statistics(to_reference), statistics(from_reference), {}};
  for (const double threshold : thresholds) {
    if (!(threshold > 0)) throw Error("a threshold is not positive", kSurfaceErrorWhere, "give thresholds in metres");
    const double precision = fraction_within(to_reference, threshold);
    const double recall = fraction_within(from_reference, threshold);
    const double sum = precision + recall;
    error.scores.push_back({threshold, precision, recall, sum > 0 ? 2 * precision * recall / sum : 0});
  }
  return error;
}

SurfaceError compare_meshes(const Mesh& reconstruction, const Mesh& reference, std::span<const double> thresholds,
                            std::size_t samples, std::uint64_t seed) {
  const std::vector<double> forth = distances_to_mesh(sample_surface(reconstruction, samples, seed), reference);
  const std::vector<double> back = distances_to_mesh(sample_surface(reference, samples, seed), reconstruction);
  return surface_error(forth, back, thresholds);
}

SurfaceError compare_points(std::span<const Mesh::Float3> reconstruction, std::span<const Mesh::Float3> reference,
                            std::span<const double> thresholds) {
  return surface_error(distances_to_points(reconstruction, reference), distances_to_points(reference, reconstruction),
                       thresholds);
}

}  // namespace plumbline::eval
