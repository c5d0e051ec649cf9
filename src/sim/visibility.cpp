#include "sim/visibility.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstdint>

#include "core/embree_scene.h"
#include "plumbline/error.h"
#include "plumbline/mesh.h"
#include "plumbline/se3.h"
#include "plumbline/trajectory.h"

namespace plumbline::sim {
namespace {

using Eigen::Vector3d;

struct View {
  SE3 camera_from_world;
  Vector3d centre;
};

bool is_clear(RTCScene scene, const Vector3d& from, const Vector3d& to) {
  constexpr float kBeforePoint = 0.998f;  // the point's own surface does not count
  return !embree::is_occluded(scene, from.cast<float>(), (to - from).cast<float>(), kBeforePoint);
}

bool in_image(const Pinhole& k, const Vector3d& p, double min_depth, double max_depth) {
  if (!(p.z() >= min_depth && p.z() <= max_depth)) return false;
  const double u = double{k.fx} * p.x() / p.z() + double{k.cx}, v = double{k.fy} * p.y() / p.z() + double{k.cy};
  return u >= -0.5 && v >= -0.5 && u < k.width - 0.5 && v < k.height - 0.5;
}

}  // namespace

std::vector<bool> seen_points(const Mesh& mesh, std::span<const Mesh::Float3> points, const Pinhole& camera,
                              const Trajectory& poses, double min_depth, double max_depth) {
  constexpr const char* kWhere = "visible surface";
  constexpr std::size_t kGrain = 512;
  if (!camera.is_valid()) throw Error("the camera's intrinsics are not valid", kWhere, "give a positive size and fx");
  const embree::Device device = embree::make_device();
  const embree::Scene scene = embree::make_scene(device.get(), mesh, kWhere);
  std::vector<View> views;
  for (const StampedPose& pose : poses)
    views.push_back({pose.world_from_camera.inverse(), pose.world_from_camera.translation()});
  std::vector<std::uint8_t> seen(points.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size(), kGrain), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const Vector3d point(points[i].x, points[i].y, points[i].z);
      for (const View& view : views) {
        if (!in_image(camera, view.camera_from_world * point, min_depth, max_depth)) continue;
        if (!is_clear(scene.get(), view.centre, point)) continue;
        seen[i] = 1;
        break;
      }
    }
  });
  return {seen.begin(), seen.end()};
}

}  // namespace plumbline::sim
