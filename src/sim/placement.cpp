// Where a recorded path fits into a scene.
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "core/embree_scene.h"
#include "core/error.h"
#include "sim/trajectory.h"

namespace plumbline::sim {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr const char* kWhere = "placement";
constexpr double kPi = std::numbers::pi;

/// Whether a surface lies within a distance of a point, by Embree's point query.
struct NearQuery {
  const Mesh* mesh;
  Vector3d point;
  double best;

  static bool visit(RTCPointQueryFunctionArguments* arguments) {
    auto* query = static_cast<NearQuery*>(arguments->userPtr);
    const Mesh::Triangle& t = query->mesh->triangles[arguments->primID];
    const double distance = query->distance(t);
    if (distance >= query->best) return false;
    query->best = distance;
    arguments->query->radius = static_cast<float>(distance);
    return true;
  }

  /// Ericson, "Real-time collision detection", 2005, §5.1.5.
  double distance(const Mesh::Triangle& t) const {
    const auto at = [&](std::uint32_t k) {
      return Vector3d(mesh->positions[k].x, mesh->positions[k].y, mesh->positions[k].z);
    };
    const Vector3d a = at(t.a), b = at(t.b), c = at(t.c), ab = b - a, ac = c - a, ap = point - a;
    const double d1 = ab.dot(ap), d2 = ac.dot(ap);
    if (d1 <= 0 && d2 <= 0) return ap.norm();
    const Vector3d bp = point - b;
    const double d3 = ab.dot(bp), d4 = ac.dot(bp);
    if (d3 >= 0 && d4 <= d3) return bp.norm();
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) return (ap - d1 / (d1 - d3) * ab).norm();
    const Vector3d cp = point - c;
    const double d5 = ab.dot(cp), d6 = ac.dot(cp);
    if (d6 >= 0 && d5 <= d6) return cp.norm();
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) return (ap - d2 / (d2 - d6) * ac).norm();
    const double va = d3 * d6 - d5 * d4, u = d4 - d3, w = d5 - d6;
    if (va <= 0 && u >= 0 && w >= 0 && u + w > 0) return (bp - u / (u + w) * (c - b)).norm();
    const double sum = va + vb + vc;
    if (!(sum > 0)) return std::min({ap.norm(), bp.norm(), cp.norm()});
    return (ap - vb / sum * ab - vc / sum * ac).norm();
  }
};

/// Rays and distances in one scene.
class Surveyor {
 public:
  explicit Surveyor(const Scene& scene)
      : scene_(scene),
        device_(embree::make_device()),
        tree_(embree::make_scene(device_.get(), scene.mesh, scene.name)) {}

  /// Metres along a unit direction, infinite where there is nothing.
  double ray(const Vector3d& origin, const Vector3d& direction) const {
    RTCRayHit r{};
    const Vector3f o = origin.cast<float>(), d = direction.cast<float>();
    r.ray.org_x = o.x();
    r.ray.org_y = o.y();
    r.ray.org_z = o.z();
    r.ray.dir_x = d.x();
    r.ray.dir_y = d.y();
    r.ray.dir_z = d.z();
    r.ray.tfar = std::numeric_limits<float>::infinity();
    r.ray.mask = ~0U;
    r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(tree_.get(), &context, &r);
    return r.hit.geomID == RTC_INVALID_GEOMETRY_ID ? std::numeric_limits<double>::infinity()
                                                   : static_cast<double>(r.ray.tfar);
  }

  /// Metres to the nearest surface, at most `limit`.
  double clearance(const Vector3d& point, double limit) const {
    RTCPointQuery query{static_cast<float>(point.x()), static_cast<float>(point.y()), static_cast<float>(point.z()), 0,
                        static_cast<float>(limit)};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    NearQuery state{&scene_.mesh, point, limit};
    rtcPointQuery(tree_.get(), &query, &context, &NearQuery::visit, &state);
    return state.best;
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

/// Shares of the rays of a Kinect's field of view.
void judge_views(const Surveyor& surveyor, const std::vector<SE3>& views, const SE3& placing, Placement* placement) {
  constexpr int kColumns = 8, kRows = 6;
  int in_range = 0, on_focus = 0;
  for (const SE3& view : views) {
    const SE3 pose = placing * view;
    for (int i = 0; i < kColumns * kRows; ++i) {
      const double x = 0.6 * (2 * ((i % kColumns) + 0.5) / kColumns - 1),
                   y = 0.45 * (2 * ((i / kColumns) + 0.5) / kRows - 1);
      const Vector3d direction = (pose.rotation() * Vector3d(x, y, 1)).normalized();
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
    const Eigen::Matrix3d rotation = Eigen::AngleAxisd(2 * kPi * turn / kTurns, Vector3d::UnitZ()).toRotationMatrix();
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
    constexpr double kLeastInRange = 0.05;  // a path that sees next to nothing is not in the scene
    if (c.placement.share_in_range >= kLeastInRange) c.score = c.placement.share_in_range + c.placement.share_on_focus;
  });
  const auto best = std::max_element(list.begin(), list.end(),
                                     [](const Candidate& a, const Candidate& b) { return a.score < b.score; });
  if (best->score < 0)
    throw Error("the path does not fit into the scene '" + scene.name + "' with " + std::to_string(clearance) +
                    " m to every surface",
                kWhere, "take a larger scene, or give the placement and a smaller clearance");
  return judge(recorded, scene, best->placing);
}

}  // namespace plumbline::sim
