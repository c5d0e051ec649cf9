#include "place/detail.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>

#include "plumbline/image.h"

namespace plumbline {
namespace {

constexpr int kColumns = 80;        // of samples
constexpr std::size_t kSeeds = 97;  // points, from one whose plane is tried to the next; shares no factor with a row
constexpr int kMaxPlanes = 8;
constexpr float kLarge = 0.04f;  // of the points: planes that hold fewer are things
constexpr float kCosine = 0.9f;  // between a point's normal and its plane's
constexpr float kThick = 0.02f;  // metres, and of the distance: how far from its plane a point is
constexpr float kMatch = 0.02f;  // metres, and of the distance

struct PlanePatch {
  Vec3<float> normal{};
  float offset = 0;
};

bool lies_on(const SurfacePoint& point, const PlanePatch& plane) {
  return dot(point.normal, plane.normal) > kCosine &&
         std::abs(dot(point.position, plane.normal) - plane.offset) < kThick * std::max(1.0f, point.depth);
}

/// How many of the points that are left lie on a plane.
std::size_t count_on(const std::vector<SurfacePoint>& points, const std::vector<std::uint8_t>& left,
                     const PlanePatch& plane) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < points.size(); ++i) count += left[i] != 0 && lies_on(points[i], plane);
  return count;
}

/// The mean of the points on a plane: a single one's normal is noisy.
PlanePatch refined(const std::vector<SurfacePoint>& points, const std::vector<std::uint8_t>& left,
                   const PlanePatch& plane) {
  Vec3<float> normal{}, position{};
  float count = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (left[i] == 0 || !lies_on(points[i], plane)) continue;
    normal = normal + points[i].normal;
    position = position + points[i].position;
    ++count;
  }
  if (count == 0) return plane;
  normal = normal * (1 / std::sqrt(dot(normal, normal)));
  return {normal, dot(position, normal) / count};
}

/// The plane that holds the most points that are left, of those about every so many of them.
PlanePatch largest_plane(const std::vector<SurfacePoint>& points, const std::vector<std::uint8_t>& left) {
  PlanePatch largest;
  std::size_t most = 0;
  for (std::size_t seed = kSeeds / 2; seed < points.size(); seed += kSeeds) {
    if (left[seed] == 0) continue;
    const PlanePatch plane{points[seed].normal, dot(points[seed].position, points[seed].normal)};
    const std::size_t count = count_on(points, left, plane);
    if (count <= most) continue;
    most = count;
    largest = plane;
  }
  return refined(points, left, largest);
}

}  // namespace

std::vector<SurfacePoint> sample_surface(const Backend& backend, const DepthLevel& level) {
  const Image<float> depth = download(backend, level.depth);
  const std::array<Image<float>, 3> normals = {download(backend, level.normal_x), download(backend, level.normal_y),
                                               download(backend, level.normal_z)};
  const int step = std::max(1, depth.width / kColumns);
  std::vector<SurfacePoint> points;
  for (int y = step / 2; y < depth.height; y += step) {
    for (int x = step / 2; x < depth.width; x += step) {
      const float z = depth.at(x, y);
      const Vec3<float> normal{normals[0].at(x, y), normals[1].at(x, y), normals[2].at(x, y)};
      const bool is_valid = z > 0 && dot(normal, normal) > 0;
      points.push_back(
          is_valid ? SurfacePoint{z, level.camera.back_project(static_cast<float>(x), static_cast<float>(y), z), normal}
                   : SurfacePoint());
    }
  }
  return points;
}

std::vector<std::uint8_t> beyond_planes(const std::vector<SurfacePoint>& points) {
  std::vector<std::uint8_t> left;
  left.reserve(points.size());
  for (const SurfacePoint& point : points) left.push_back(point.depth > 0 ? 1 : 0);
  const auto large = static_cast<std::size_t>(kLarge * static_cast<float>(points.size()));
  for (int i = 0; i < kMaxPlanes; ++i) {
    const PlanePatch plane = largest_plane(points, left);
    if (count_on(points, left, plane) < std::max<std::size_t>(large, 1)) break;
    for (std::size_t k = 0; k < points.size(); ++k)
      if (lies_on(points[k], plane)) left[k] = 0;
  }
  return left;
}

DetailComparison compare_detail(const std::vector<SurfacePoint>& a, const std::vector<SurfacePoint>& b) {
  const std::vector<std::uint8_t> detail_a = beyond_planes(a), detail_b = beyond_planes(b);
  DetailComparison comparison;
  for (std::size_t i = 0; i < a.size() && i < b.size(); ++i) {
    if (!(a[i].depth > 0) || !(b[i].depth > 0)) continue;
    ++comparison.readings;
    if (detail_a[i] == 0 && detail_b[i] == 0) continue;
    ++comparison.detail;
    comparison.matched += std::abs(a[i].depth - b[i].depth) < kMatch * std::max(1.0f, b[i].depth);
  }
  return comparison;
}

}  // namespace plumbline
