#include "graph/view_comparison.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace plumbline {
namespace {

constexpr double kSigmas = 4;          // beyond so many deviations of both readings a surface is another one
constexpr double kCalibration = 0.01;  // of the depth: what is left of a camera's distortion

/// Nearest and farthest reading about a pixel.
struct Neighbourhood {
  float nearest, farthest;
};

/// Nothing where a neighbour has no reading: at edges and holes a comparison says nothing.
std::optional<Neighbourhood> around(const Image<float>& depth, int x, int y) {
  if (x < 1 || y < 1 || x + 1 >= depth.width || y + 1 >= depth.height) return std::nullopt;
  Neighbourhood n{depth.at(x, y), depth.at(x, y)};
  for (int row = y - 1; row <= y + 1; ++row) {
    for (int column = x - 1; column <= x + 1; ++column) {
      const float z = depth.at(column, row);
      if (!(z > 0)) return std::nullopt;
      n.nearest = std::min(n.nearest, z);
      n.farthest = std::max(n.farthest, z);
    }
  }
  return n;
}

}  // namespace

double depth_sigma(double depth) {
  constexpr double kBase = 0.0012, kSlope = 0.0019, kNearest = 0.4;
  return kBase + kSlope * (depth - kNearest) * (depth - kNearest);
}

ViewOverlap compare_views(const Image<float>& depth, const Image<float>& other, const Pinhole& camera,
                          const SE3& other_from_view, int stride) {
  ViewOverlap overlap;
  const RigidTransform transform = to_kernel(other_from_view);
  for (int y = stride / 2; y < depth.height; y += stride) {
    for (int x = stride / 2; x < depth.width; x += stride) {
      const float z = depth.at(x, y);
      if (!(z > 0)) continue;
      ++overlap.readings;
      const Vec3<float> p = transform.apply(camera.back_project(static_cast<float>(x), static_cast<float>(y), z));
      if (!(p.z > 0.1f)) continue;
      const auto u = static_cast<int>(std::floor(p.x / p.z * camera.fx + camera.cx + 0.5f)),
                 v = static_cast<int>(std::floor(p.y / p.z * camera.fy + camera.cy + 0.5f));
      const std::optional<Neighbourhood> seen = around(other, u, v);
      if (!seen) continue;
      ++overlap.known;
      const double sigma = std::hypot(depth_sigma(z), depth_sigma(static_cast<double>(seen->nearest)));
      const double tolerance = kSigmas * sigma + kCalibration * static_cast<double>(p.z);
      const double nearest = static_cast<double>(seen->nearest) - tolerance,
                   farthest = static_cast<double>(seen->farthest) + tolerance, at = static_cast<double>(p.z);
      overlap.in_front += at < nearest;
      overlap.on += at >= nearest && at <= farthest;
    }
  }
  return overlap;
}

}  // namespace plumbline
