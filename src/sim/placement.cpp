// Where a recorded path fits into a scene.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "core/embree_scene.h"
#include "plumbline/error.h"
#include "plumbline/se3.h"
#include "sim/trajectory.h"

namespace plumbline::sim {
namespace {

using Eigen::Vector3d;

constexpr const char* kPlacementWhere = "placement";

/// Rays and distances in one scene.
class Surveyor {
 public:
  explicit Surveyor(const Scene& scene)
      : scene_(scene),
        device_(embree::make_device()),
        tree_(embree::make_scene(device_.get(), scene.mesh, scene.name)) {}

  /// Metres along a unit direction, infinite where there is nothing.
  double ray(const Vector3d& origin, const Vector3d& direction) const {
    const RTCRayHit r = embree::intersect(tree_.get(), origin.cast<float>(), direction.cast<float>());
    return r.hit.geomID == RTC_INVALID_GEOMETRY_ID ? std::numeric_limits<double>::infinity()
                                                   : static_cast<double>(r.ray.tfar);
  }

  /// Metres to the nearest surface, at most `limit`.
  double clearance(const Vector3d& point, double limit) const {
    return embree::distance_to_mesh(tree_.get(), scene_.mesh, point, limit);
  }

  /// True where the path's line from one point to the next meets a surface.
  bool crosses(const Vector3d& a, const Vector3d& b) const {
    const double length = (b - a).norm();
    return length > 1e-6 && ray(a, (b - a) / length) < length;
  }

  /// Under everything: nothing below and something above.
  bool is_below_floor(const Vector3d& point) const {
    return !std::isfinite(ray(point, -Vector3d::UnitZ())) && std::isfinite(ray(point, Vector3d::UnitZ()));
  }

  const Scene& scene() const { return scene_; }

 private:
  const Scene& scene_;
  embree::Device device_;
  embree::Scene tree_;
};

std::vector<SE3> sampled(const Motion& motion, int count) {
  std::vector<SE3> views;
  for (int i = 0; i < count; ++i) views.push_back(motion.at(motion.duration() * i / (count - 1)));
  return views;
}

constexpr int kColumns = 8, kRows = 6;  // of the rays of a view

/// Not normalised, in the camera's axes.
Vector3d viewing_ray(int i) {
  const double x = 0.6 * (2 * ((i % kColumns) + 0.5) / kColumns - 1),
               y = 0.45 * (2 * ((i / kColumns) + 0.5) / kRows - 1);
  return {x, y, 1};
}

/// Shares of the rays of a Kinect's field of view.
void judge_views(const Surveyor& surveyor, const std::vector<SE3>& views, const SE3& placing, Placement* placement) {
  int in_range = 0, on_focus = 0;
  for (const SE3& view : views) {
    const SE3 pose = placing * view;
    for (int i = 0; i < kColumns * kRows; ++i) {
      const Vector3d direction = (pose.rotation() * viewing_ray(i)).normalized();
      const double t = surveyor.ray(pose.translation(), direction);
      if (!(t > 0.5 && t < 4)) continue;
      ++in_range;
      const Vector3d point = pose.translation() + t * direction;
      if ((point - surveyor.scene().focus).norm() < surveyor.scene().focus_radius) ++on_focus;
    }
  }
  const double rays = static_cast<double>(views.size()) * kColumns * kRows;
  placement->share_in_range = in_range / rays;
  placement->share_on_focus = on_focus / rays;
}

/// Smallest distance of the path to a surface, at most 1 m; negative where it passes through one or under the floor.
double path_clearance(const Surveyor& surveyor, const std::vector<SE3>& path, const SE3& placing, double needed) {
  double clearance = 1;
  Vector3d before = placing * path.front().translation();
  for (const SE3& pose : path) {
    const Vector3d at = placing * pose.translation();
    if (surveyor.is_below_floor(at)) return -1;
    clearance = std::min(clearance, surveyor.clearance(at, clearance));
    if (clearance < needed || surveyor.crosses(before, at)) return -1;
    before = at;
  }
  return clearance;
}

struct Candidate {
  SE3 placing;
  double score = -1;
  Placement placement;
};

/// Turns about the vertical and moves that bring the point most looked at to the focus, and its surroundings.
std::vector<Candidate> candidates(const std::vector<SE3>& views, const Scene& scene) {
  constexpr int kTurns = 24;
  Vector3d looked_at = Vector3d::Zero();
  for (const SE3& view : views) looked_at += view * Vector3d(0, 0, 1.3) / static_cast<double>(views.size());
  std::vector<Candidate> list;
  for (int turn = 0; turn < kTurns; ++turn) {
    const Eigen::Matrix3d rotation =
        Eigen::AngleAxisd(2 * std::numbers::pi * turn / kTurns, Vector3d::UnitZ()).toRotationMatrix();
    for (int x = -3; x <= 3; ++x)
      for (int y = -3; y <= 3; ++y)
        for (int z = -1; z <= 2; ++z) {
          const Vector3d offset(0.3 * x, 0.3 * y, 0.2 * z);
          list.push_back({SE3(rotation, scene.focus + offset - rotation * looked_at), -1, {}});
        }
  }
  return list;
}

}  // namespace

Placement judge(const Motion& recorded, const Scene& scene, const SE3& scene_from_recorded) {
  constexpr int kPathPoints = 400, kViews = 60;
  const Surveyor surveyor(scene);
  Placement placement;
  placement.scene_from_recorded = scene_from_recorded;
  placement.clearance = path_clearance(surveyor, sampled(recorded, kPathPoints), scene_from_recorded, 0);
  judge_views(surveyor, sampled(recorded, kViews), scene_from_recorded, &placement);
  return placement;
}

Placement place(const Motion& recorded, const Scene& scene, double clearance) {
  constexpr int kPathPoints = 400, kViews = 24;
  const Surveyor surveyor(scene);
  const std::vector<SE3> path = sampled(recorded, kPathPoints), views = sampled(recorded, kViews);
  std::vector<Candidate> list = candidates(views, scene);
  tbb::parallel_for(std::size_t{0}, list.size(), [&](std::size_t i) {
    Candidate& c = list[i];
    c.placement.scene_from_recorded = c.placing;
    c.placement.clearance = path_clearance(surveyor, path, c.placing, clearance);
    if (c.placement.clearance < 0) return;
    judge_views(surveyor, views, c.placing, &c.placement);
    constexpr double kMinInRange = 0.05;  // a path that sees next to nothing is not in the scene
    if (c.placement.share_in_range >= kMinInRange) c.score = c.placement.share_in_range + c.placement.share_on_focus;
  });
  const auto best = std::max_element(list.begin(), list.end(),
                                     [](const Candidate& a, const Candidate& b) { return a.score < b.score; });
  if (best->score < 0)
    throw Error("the path does not fit into the scene '" + scene.name + "' with " + std::to_string(clearance) +
                    " m to every surface",
                kPlacementWhere, "take a larger scene, or give the placement and a smaller clearance");
  return judge(recorded, scene, best->placing);
}

}  // namespace plumbline::sim
