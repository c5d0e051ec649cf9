#include "sim/analytic_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <utility>

#include "core/random.h"
#include "plumbline/error.h"
#include "plumbline/image.h"
#include "plumbline/mesh.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"

namespace plumbline::sim {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// What a ray meets of one solid, in the solid's frame.
struct LocalHit {
  double t = kInfinity;
  Vector3d outward = Vector3d::Zero();
};

/// The part of a ray within a solid: the nearer of its two ends that lies ahead is the surface seen.
struct Span {
  double enter = -kInfinity, leave = kInfinity;

  double first_ahead() const {
    if (enter > leave) return kInfinity;
    if (enter > 0) return enter;
    return leave > 0 ? leave : kInfinity;
  }
};

LocalHit intersect_half_space(const Vector3d& origin, const Vector3d& direction) {
  const double t = -origin.z() / direction.z();  // a parallel ray gives ±infinity or NaN, which the comparison rejects
  return t > 0 && t < kInfinity ? LocalHit{t, Vector3d::UnitZ()} : LocalHit{};
}

/// Roots of |origin + t direction|² = radius² for the given squares; an empty span where there are none. The root of
/// larger magnitude is computed first, so that neither suffers cancellation.
Span quadratic_span(double a, double half_b, double c) {
  const double discriminant = half_b * half_b - a * c;
  if (discriminant < 0 || a == 0) return {kInfinity, -kInfinity};
  const double q = -(half_b + std::copysign(std::sqrt(discriminant), half_b));
  if (q == 0) return {0, 0};
  const auto [low, high] = std::minmax({q / a, c / q});
  return {low, high};
}

LocalHit intersect_sphere(double radius, const Vector3d& origin, const Vector3d& direction) {
  const double c = (origin.norm() - radius) * (origin.norm() + radius);
  const double t = quadratic_span(direction.squaredNorm(), origin.dot(direction), c).first_ahead();
  if (t == kInfinity) return {};
  return {t, (origin + t * direction) / radius};
}

/// Narrows the span to the slab |coordinate| ≤ half; false when nothing is left.
bool clip_slab(double origin, double direction, double half, Span* span) {
  if (direction == 0) return std::abs(origin) <= half;
  const double inverse = 1 / direction;
  const double centre = -origin * inverse, reach = half * std::abs(inverse);
  span->enter = std::max(span->enter, centre - reach);
  span->leave = std::min(span->leave, centre + reach);
  return span->enter <= span->leave;
}

LocalHit intersect_box(const Vector3d& half, const Vector3d& origin, const Vector3d& direction) {
  Span span;
  for (int axis = 0; axis < 3; ++axis) {
    if (!clip_slab(origin[axis], direction[axis], half[axis], &span)) return {};
  }
  const double t = span.first_ahead();
  if (t == kInfinity) return {};
  const Vector3d relative = (origin + t * direction).cwiseQuotient(half);
  int face = 0;
  relative.cwiseAbs().maxCoeff(&face);
  return {t, Vector3d::Unit(face) * (relative[face] < 0 ? -1 : 1)};
}

LocalHit intersect_cylinder(const Vector3d& size, const Vector3d& origin, const Vector3d& direction) {
  Span span;
  if (!clip_slab(origin.z(), direction.z(), size.z(), &span)) return {};
  const double a = direction.head<2>().squaredNorm();
  const double distance = origin.head<2>().norm();
  const double c = (distance - size.x()) * (distance + size.x());
  if (a > 0) {
    const Span side = quadratic_span(a, origin.head<2>().dot(direction.head<2>()), c);
    span = {std::max(span.enter, side.enter), std::min(span.leave, side.leave)};
  } else if (c > 0) {
    return {};
  }
  const double t = span.first_ahead();
  if (t == kInfinity) return {};
  const Vector3d point = origin + t * direction;
  if (size.z() - std::abs(point.z()) < size.x() - point.head<2>().norm()) {
    return {t, Vector3d::UnitZ() * (point.z() < 0 ? -1 : 1)};
  }
  return {t, Vector3d(point.x(), point.y(), 0).normalized()};
}

LocalHit intersect_local(const Primitive& p, const Vector3d& origin, const Vector3d& direction) {
  switch (p.shape) {
    case Primitive::Shape::half_space:
      return intersect_half_space(origin, direction);
    case Primitive::Shape::sphere:
      return intersect_sphere(p.size.x(), origin, direction);
    case Primitive::Shape::box:
      return intersect_box(p.size, origin, direction);
    case Primitive::Shape::cylinder:
      return intersect_cylinder(p.size, origin, direction);
  }
  return {};
}

/// Signed distance to a box from the excess over its half extents in 3D, or to a cylinder in its (radius, height)
/// plane.
template <class Excess>
double distance_from_excess(const Excess& excess) {
  return excess.cwiseMax(0).norm() + std::min(excess.maxCoeff(), 0.0);
}

double signed_distance_local(const Primitive& p, const Vector3d& point) {
  switch (p.shape) {
    case Primitive::Shape::half_space:
      return point.z();
    case Primitive::Shape::sphere:
      return point.norm() - p.size.x();
    case Primitive::Shape::box:
      return distance_from_excess((point.cwiseAbs() - p.size).eval());
    case Primitive::Shape::cylinder:
      return distance_from_excess(
          Eigen::Vector2d(point.head<2>().norm() - p.size.x(), std::abs(point.z()) - p.size.z()));
  }
  return kInfinity;
}

double fraction(double value) { return value - std::floor(value); }

/// The cell's phase is shifted by an odd amount, so that faces through the origin do not lie on a boundary of cells.
Mesh::Rgb color_at(const Pattern& pattern, const Vector3d& point) {
  const Vector3d cell = point / pattern.period + Vector3d::Constant(0.11);
  switch (pattern.kind) {
    case Pattern::Kind::solid:
      return pattern.first;
    case Pattern::Kind::checker: {
      const Vector3d half = (cell * 2).array().floor();
      return fraction(half.sum() / 2) == 0 ? pattern.first : pattern.second;
    }
    case Pattern::Kind::stripes:
      return fraction(cell.x() + cell.y()) < 0.5 ? pattern.first : pattern.second;
    case Pattern::Kind::dots: {
      const Vector3d offset = cell.array() - cell.array().floor() - 0.5;
      return offset.norm() > 0.4 ? pattern.first : pattern.second;
    }
  }
  return pattern.first;
}

/// Rotation that takes z to the given unit vector.
Matrix3d rotation_to(const Vector3d& z) { return Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), z).matrix(); }

SE3 upright(double x, double y, double z, double yaw = 0) {
  return {Eigen::AngleAxisd(yaw, Vector3d::UnitZ()).toRotationMatrix(), Vector3d(x, y, z)};
}

void add_table(AnalyticScene* scene) {
  const Pattern top{Pattern::Kind::stripes, {176, 128, 84}, {160, 112, 70}, 0.16};
  const Pattern leg{Pattern::Kind::solid, {70, 72, 78}, {}, 1};
  const Vector3d centre(-0.45, -0.5, 0.70);
  scene->primitives.push_back(box(SE3(Matrix3d::Identity(), centre), {0.60, 0.42, 0.02}, top));
  for (const double x : {-0.54, 0.54}) {
    for (const double y : {-0.36, 0.36}) {
      scene->primitives.push_back(cylinder(upright(centre.x() + x, centre.y() + y, 0.34), 0.03, 0.34, leg));
    }
  }
}

void add_objects(AnalyticScene* scene) {
  auto& list = scene->primitives;
  const double top = 0.72;
  list.push_back(box(upright(-0.78, -0.68, top + 0.15, 0.5), {0.16, 0.10, 0.15},
                     {Pattern::Kind::checker, {196, 72, 60}, {226, 196, 170}, 0.12}));
  list.push_back(sphere({-0.36, -0.36, top + 0.13}, 0.13, {Pattern::Kind::dots, {238, 190, 64}, {64, 110, 170}, 0.11}));
  list.push_back(cylinder(upright(-0.02, -0.66, top + 0.14), 0.07, 0.14,
                          {Pattern::Kind::checker, {66, 140, 122}, {214, 226, 214}, 0.08}));
  const Matrix3d tilt = (Eigen::AngleAxisd(-0.4, Vector3d::UnitZ()) * Eigen::AngleAxisd(0.6, Vector3d::UnitX()) *
                         Eigen::AngleAxisd(0.35, Vector3d::UnitY()))
                            .toRotationMatrix();
  list.push_back(box(SE3(tilt, {-0.14, -0.24, top + 0.08}), {0.07, 0.09, 0.05},
                     {Pattern::Kind::stripes, {104, 84, 160}, {206, 198, 226}, 0.06}));
  list.push_back(box(upright(0.62, -0.80, 0.25, 0.3), {0.20, 0.26, 0.25},
                     {Pattern::Kind::checker, {92, 124, 168}, {150, 176, 206}, 0.2}));
  list.push_back(sphere({-0.86, 0.42, 0.24}, 0.24, {Pattern::Kind::dots, {206, 214, 206}, {184, 92, 96}, 0.2}));
}

/// Band-limited noise of unit rms: a sum of sines between 0.4 and 3 Hz, where the power of a hand's motion lies.
class Shake {
 public:
  explicit Shake(std::mt19937_64* random) {
    for (Sine& sine : sines_) sine = {0.4 + 2.6 * uniform(random), 2 * std::numbers::pi * uniform(random)};
  }

  double at(double seconds) const {
    double sum = 0;
    for (const Sine& s : sines_) sum += std::sin(2 * std::numbers::pi * s.frequency * seconds + s.phase);
    return sum * std::sqrt(2.0 / kSines);
  }

 private:
  static constexpr int kSines = 5;
  struct Sine {
    double frequency, phase;
  };

  std::array<Sine, kSines> sines_{};
};

/// The path without shake.
SE3 orbit_pose(const OrbitOptions& o, double seconds) {
  const double phase = 2 * std::numbers::pi * seconds / o.period;
  const double azimuth = o.azimuth + o.amplitude * std::sin(phase);
  const double radius = o.radius * (1 + 0.06 * std::sin(2 * phase + 0.7));
  const double height = o.height + 0.08 * o.radius * std::sin(3 * phase);
  const Vector3d eye(o.target.x() + radius * std::cos(azimuth), o.target.y() + radius * std::sin(azimuth), height);
  return look_at(eye, o.target);
}

}  // namespace

Primitive plane(const Vector3d& point, const Vector3d& normal, const Pattern& pattern) {
  return {Primitive::Shape::half_space, Vector3d::Ones(), SE3(rotation_to(normal.normalized()), point), pattern};
}

Primitive sphere(const Vector3d& center, double radius, const Pattern& pattern) {
  return {Primitive::Shape::sphere, Vector3d::Constant(radius), SE3(Matrix3d::Identity(), center), pattern};
}

Primitive box(const SE3& world_from_box, const Vector3d& half_extents, const Pattern& pattern) {
  return {Primitive::Shape::box, half_extents, world_from_box, pattern};
}

Primitive cylinder(const SE3& world_from_cylinder, double radius, double half_height, const Pattern& pattern) {
  return {Primitive::Shape::cylinder, {radius, radius, half_height}, world_from_cylinder, pattern};
}

double AnalyticScene::signed_distance(const Vector3d& point_world) const {
  double nearest = kInfinity;
  for (const Primitive& p : primitives) {
    nearest = std::min(nearest, signed_distance_local(p, p.world_from_local.inverse() * point_world));
  }
  return nearest;
}

double AnalyticScene::distance(const Vector3d& point_world) const { return std::abs(signed_distance(point_world)); }

namespace {

LocalHit intersect_primitive(const Primitive& primitive, const Vector3d& origin_world,
                             const Vector3d& direction_world) {
  const SE3& pose = primitive.world_from_local;
  const Vector3d origin = pose.rotation().transpose() * (origin_world - pose.translation());
  return intersect_local(primitive, origin, pose.rotation().transpose() * direction_world);
}

}  // namespace

std::optional<Hit> AnalyticScene::intersect(const Vector3d& origin_world, const Vector3d& direction_world) const {
  LocalHit best;
  std::size_t index = primitives.size();
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    const LocalHit hit = intersect_primitive(primitives[i], origin_world, direction_world);
    if (hit.t < best.t) {
      best = hit;
      index = i;
    }
  }
  if (index == primitives.size()) return std::nullopt;
  const SE3& pose = primitives[index].world_from_local;
  const Vector3d point = origin_world + best.t * direction_world;
  Vector3d normal = pose.rotation() * best.outward;
  if (normal.dot(direction_world) > 0) normal = -normal;
  return Hit{best.t, normal, color_at(primitives[index].pattern, pose.inverse() * point), index};
}

AnalyticScene desk_corner() {
  AnalyticScene scene;
  scene.primitives = {
      plane({0, 0, 0}, {0, 0, 1}, {Pattern::Kind::checker, {150, 146, 140}, {128, 124, 118}, 0.5}),
      plane({-1.25, 0, 0}, {1, 0, 0}, {Pattern::Kind::stripes, {214, 220, 214}, {200, 208, 202}, 0.3}),
      plane({0, -1.25, 0}, {0, 1, 0}, {Pattern::Kind::checker, {222, 212, 198}, {210, 200, 186}, 0.6}),
  };
  add_table(&scene);
  add_objects(&scene);
  return scene;
}

Frame render(const AnalyticScene& scene, const Pinhole& camera, const SE3& world_from_camera, Nanoseconds time,
             double depth_scale, bool color) {
  if (!camera.is_valid()) throw Error("the camera's intrinsics are not valid", "render", "give a positive size and fx");
  if (!(depth_scale > 0)) throw Error("the depth scale is not positive", "render", "give readings per metre");
  Frame frame;
  frame.time = time;
  frame.depth_scale = depth_scale;
  frame.depth = DepthImage(camera.width, camera.height);
  if (color) frame.color = ColorImage(camera.width, camera.height, 3);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      // A direction with z = 1 makes the ray's parameter the depth itself.
      const Vector3d ray((u - double{camera.cx}) / camera.fx, (v - double{camera.cy}) / camera.fy, 1);
      const auto hit = scene.intersect(world_from_camera.translation(), world_from_camera.rotation() * ray);
      if (!hit) continue;
      const double reading = std::round(hit->t * depth_scale);
      if (reading <= 65535) frame.depth.at(u, v) = static_cast<std::uint16_t>(reading);
      if (!color) continue;
      frame.color.at(u, v, 0) = hit->color.r;
      frame.color.at(u, v, 1) = hit->color.g;
      frame.color.at(u, v, 2) = hit->color.b;
    }
  }
  return frame;
}

SE3 look_at(const Vector3d& eye, const Vector3d& target, const Vector3d& up) {
  const Vector3d forward = (target - eye).normalized();
  const Vector3d right = forward.cross(up);
  if (!forward.allFinite() || !(forward.norm() > 0.5) || !(right.norm() > 1e-9 * up.norm())) {
    throw Error("a camera cannot look at its own centre or along the up direction", "look_at", "move the eye");
  }
  Matrix3d rotation;
  rotation.col(0) = right.normalized();
  rotation.col(1) = forward.cross(rotation.col(0));
  rotation.col(2) = forward;
  return {rotation, eye};
}

Trajectory orbit(const OrbitOptions& o) {
  if (o.frames < 1 || !(o.rate > 0) || !(o.period > 0)) {
    throw Error("an orbit needs at least one frame and a positive rate and period", "orbit", "correct the options");
  }
  std::mt19937_64 random(o.seed);
  std::vector<Shake> shake;  // three turns, then three moves
  shake.reserve(6);
  for (int i = 0; i < 6; ++i) shake.emplace_back(&random);
  Trajectory trajectory;
  trajectory.reserve(static_cast<std::size_t>(o.frames));
  for (int i = 0; i < o.frames; ++i) {
    const double seconds = i / o.rate;
    const SE3 smooth = orbit_pose(o, seconds);
    Vector3d turn, move;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      turn[static_cast<Eigen::Index>(axis)] = o.shake_rotation * shake[axis].at(seconds);
      move[static_cast<Eigen::Index>(axis)] = o.shake_translation * shake[axis + 3].at(seconds);
    }
    const SE3 pose(smooth.rotation() * so3::exp(turn), smooth.translation() + move);
    trajectory.push_back({o.start + from_seconds(seconds), pose});
  }
  return trajectory;
}

}  // namespace plumbline::sim
