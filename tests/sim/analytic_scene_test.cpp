#include "sim/analytic_scene.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <random>
#include <vector>

#include "plumbline/error.h"
#include "plumbline/frame.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "plumbline/trajectory.h"

namespace plumbline::sim {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr Pinhole kCamera{262.5f, 262.5f, 159.5f, 119.5f, 320, 240};

AnalyticScene one(const Primitive& primitive) { return {{primitive}}; }

Vector3d ray_through(const Pinhole& k, int u, int v) {
  return {(u - double{k.cx}) / k.fx, (v - double{k.cy}) / k.fy, 1};
}

SE3 tilted(double x, double y, double z) { return {so3::exp({0.3, -0.5, 0.8}), Vector3d(x, y, z)}; }

AnalyticScene one_of_each() {
  return {{sphere({0.4, -0.3, 2.6}, 0.5), box(tilted(-0.7, 0.3, 2.2), {0.3, 0.2, 0.4}),
           cylinder(tilted(0.5, 0.7, 2.4), 0.2, 0.35), plane({0, 0, 3.5}, {0.2, -0.1, -1})}};
}

TEST(AnalyticScene, PlaneDepthIsTheClosedForm) {
  const Vector3d normal = Vector3d(0.3, -0.2, -1).normalized(), point(0, 0, 1.7);
  const Frame frame = render(one(plane(point, normal)), kCamera, SE3(), 0, 10000);
  for (int v = 0; v < kCamera.height; v += 7) {
    for (int u = 0; u < kCamera.width; u += 7) {
      const double depth = normal.dot(point) / normal.dot(ray_through(kCamera, u, v));
      EXPECT_NEAR(frame.depth.at(u, v) / 10000.0, depth, 0.5001e-4);
    }
  }
}

TEST(AnalyticScene, SphereDepthAndNormalAreTheClosedForm) {
  const Vector3d center(0.1, -0.05, 2);
  const double radius = 0.6;
  const AnalyticScene scene = one(sphere(center, radius));
  const Frame frame = render(scene, kCamera, SE3(), 0, 10000);
  int seen = 0;
  for (int v = 0; v < kCamera.height; v += 3) {
    for (int u = 0; u < kCamera.width; u += 3) {
      const Vector3d d = ray_through(kCamera, u, v);
      const double b = d.dot(center), discriminant = b * b - d.squaredNorm() * (center.squaredNorm() - radius * radius);
      if (std::abs(discriminant) < 1e-9) continue;
      ASSERT_EQ(frame.depth.at(u, v) != 0, discriminant > 0) << u << " " << v;
      if (discriminant < 0) continue;
      ++seen;
      const double depth = (b - std::sqrt(discriminant)) / d.squaredNorm();
      EXPECT_NEAR(frame.depth.at(u, v) / 10000.0, depth, 0.5001e-4);
      const auto hit = scene.intersect(Vector3d::Zero(), d);
      ASSERT_TRUE(hit);
      EXPECT_NEAR(hit->t, depth, 1e-12);
      EXPECT_LT((hit->normal - (depth * d - center) / radius).norm(), 1e-9);
    }
  }
  EXPECT_GT(seen, 1000);
}

TEST(AnalyticScene, PoseOfTheCameraMovesTheImageAndNotTheDepth) {
  const SE3 world_from_camera = tilted(0.4, -0.8, 1.1);
  AnalyticScene moved = one_of_each();
  for (Primitive& p : moved.primitives) p.world_from_local = world_from_camera * p.world_from_local;
  const Frame at_origin = render(one_of_each(), kCamera, SE3());
  const Frame elsewhere = render(moved, kCamera, world_from_camera);
  int differing = 0;
  for (std::size_t i = 0; i < at_origin.depth.pixels.size(); ++i) {
    differing += std::abs(at_origin.depth.pixels[i] - elsewhere.depth.pixels[i]) > 1;
  }
  EXPECT_LT(differing, 10);  // rays that graze an edge
}

TEST(AnalyticScene, HitsLieOnTheSurfaceAndNormalsAreTheGradientOfTheDistance) {
  const AnalyticScene scene = one_of_each();
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<int> hits(scene.primitives.size(), 0);
  for (int i = 0; i < 20000; ++i) {
    const Vector3d origin(uniform(random), uniform(random), 0.2 * uniform(random));
    const Vector3d direction(0.6 * uniform(random), 0.6 * uniform(random), 0.5 + std::abs(uniform(random)));
    const auto hit = scene.intersect(origin, direction);
    ASSERT_TRUE(hit);
    ++hits[hit->primitive];
    const Vector3d point = origin + hit->t * direction;
    ASSERT_LT(scene.distance(point), 1e-9);
    EXPECT_NEAR(hit->normal.norm(), 1, 1e-12);
    EXPECT_LT(hit->normal.dot(direction), 1e-12);
    // Along the normal the distance grows as the way does, wherever this solid stays the nearest.
    const AnalyticScene alone = one(scene.primitives[hit->primitive]);
    EXPECT_NEAR(alone.signed_distance(point + 1e-4 * hit->normal), 1e-4, 1e-9);
    // Nothing is passed on the way.
    for (const double share : {0.25, 0.5, 0.9, 0.99})
      EXPECT_GT(scene.signed_distance(origin + share * hit->t * direction), 0);
  }
  for (const int count : hits) EXPECT_GT(count, 300);
}

TEST(AnalyticScene, SphereTracingByDistanceFindsTheSameSurface) {
  const AnalyticScene scene = desk_corner();
  const SE3 pose = orbit({.frames = 1}).front().world_from_camera;
  for (int v = 5; v < kCamera.height; v += 23) {
    for (int u = 5; u < kCamera.width; u += 23) {
      const Vector3d direction = pose.rotation() * ray_through(kCamera, u, v).normalized();
      const auto hit = scene.intersect(pose.translation(), direction);
      ASSERT_TRUE(hit);
      double t = 0;
      for (int i = 0; i < 2000 && scene.signed_distance(pose.translation() + t * direction) > 1e-7; ++i) {
        t += scene.signed_distance(pose.translation() + t * direction);
      }
      EXPECT_NEAR(t, hit->t, 1e-4);
    }
  }
}

TEST(AnalyticScene, DistanceOfABoxIsExactOutsideAndInside) {
  const AnalyticScene scene = one(box(SE3(), {1, 2, 3}));
  EXPECT_NEAR(scene.signed_distance({4, 0, 0}), 3, 1e-12);
  EXPECT_NEAR(scene.signed_distance({2, 3, 4}), std::sqrt(3.0), 1e-12);
  EXPECT_NEAR(scene.signed_distance({0.6, 0, 0}), -0.4, 1e-12);
  EXPECT_NEAR(scene.distance({0.6, 0, 0}), 0.4, 1e-12);
}

TEST(AnalyticScene, RayFromWithinMeetsTheFarSideWithTheNormalTowardsIt) {
  for (const Primitive& p : {sphere({0, 0, 0}, 1), box(SE3(), {1, 1, 1}), cylinder(SE3(), 1, 1)}) {
    const auto hit = one(p).intersect({0.2, 0, 0}, {2, 0, 0});
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->t, 0.4, 1e-12);
    EXPECT_LT((hit->normal - Vector3d(-1, 0, 0)).norm(), 1e-12);
  }
}

TEST(AnalyticScene, MissesAndRaysAlongASurface) {
  EXPECT_FALSE(one(sphere({0, 0, 5}, 1)).intersect({0, 0, 0}, {0, 0, -1}));
  EXPECT_FALSE(one(plane({0, 0, 0}, {0, 0, 1})).intersect({0, 0, 1}, {1, 0, 0}));
  EXPECT_FALSE(one(box(SE3(), {1, 1, 1})).intersect({2, 0, -5}, {0, 0, 1}));
  EXPECT_FALSE(one(cylinder(SE3(), 1, 1)).intersect({2, 0, -5}, {0, 0, 1}));
  const auto cap = one(cylinder(SE3(), 1, 1)).intersect({0.5, 0, -5}, {0, 0, 1});
  ASSERT_TRUE(cap);
  EXPECT_NEAR(cap->t, 4, 1e-12);
  EXPECT_FALSE(AnalyticScene{}.intersect({0, 0, 0}, {0, 0, 1}));
  EXPECT_TRUE(std::isinf(AnalyticScene{}.distance({0, 0, 0})));
}

TEST(AnalyticScene, ReadingsThatDoNotFitAreNone) {
  const AnalyticScene scene = one(plane({0, 0, 13.2}, {0, 0, -1}));
  EXPECT_EQ(render(scene, kCamera, SE3(), 0, 5000).depth.at(10, 10), 0);
  EXPECT_EQ(render(scene, kCamera, SE3(), 0, 1000).depth.at(10, 10), 13200);
  EXPECT_TRUE(render(scene, kCamera, SE3(), 0, 1000, false).color.empty());
  EXPECT_EQ(render(scene, kCamera, SE3(), 42).time, 42);
  EXPECT_THROW(render(scene, Pinhole{}, SE3()), Error);
  EXPECT_THROW(render(scene, kCamera, SE3(), 0, 0), Error);
}

TEST(AnalyticScene, NegativeFyTurnsTheImageUpsideDown) {
  Pinhole flipped = kCamera;
  flipped.fy = -flipped.fy;
  const Frame up = render(one_of_each(), flipped, SE3()), down = render(one_of_each(), kCamera, SE3());
  for (int v = 0; v < kCamera.height; v += 11) {
    for (int u = 0; u < kCamera.width; u += 11) {
      EXPECT_EQ(up.depth.at(u, v), down.depth.at(u, kCamera.height - 1 - v));
      EXPECT_EQ(up.color.at(u, v, 1), down.color.at(u, kCamera.height - 1 - v, 1));
    }
  }
}

TEST(AnalyticScene, PatternsAreTheSameFromEveryView) {
  const AnalyticScene scene = desk_corner();
  const auto seen = scene.intersect({1, 1, 1.5}, {-1, -1.1, -1.2});
  ASSERT_TRUE(seen);
  const Vector3d point = Vector3d(1, 1, 1.5) + seen->t * Vector3d(-1, -1.1, -1.2);
  const Vector3d elsewhere = point + Vector3d(0.2, 0.1, 0.3);
  const auto again = scene.intersect(elsewhere, point - elsewhere);
  ASSERT_TRUE(again);
  EXPECT_NEAR(again->t, 1, 1e-9);
  EXPECT_EQ(again->color.r, seen->color.r);
  EXPECT_EQ(again->color.b, seen->color.b);
}

TEST(DeskCorner, EveryFrameOfTheOrbitSeesTheSceneWithinASensorsRange) {
  const AnalyticScene scene = desk_corner();
  constexpr Pinhole small{131.25f, 131.25f, 79.5f, 59.5f, 160, 120};
  const Trajectory path = orbit();
  for (std::size_t i = 0; i < path.size(); i += 4) {
    const Frame frame = render(scene, small, path[i].world_from_camera, 0, 5000, false);
    const auto in_range = std::count_if(frame.depth.pixels.begin(), frame.depth.pixels.end(),
                                        [](std::uint16_t d) { return d >= 2000 && d <= 20000; });
    EXPECT_GT(static_cast<double>(in_range) / static_cast<double>(frame.depth.pixels.size()), 0.6) << "frame " << i;
    EXPECT_GT(scene.signed_distance(path[i].world_from_camera.translation()), 0.3);
  }
}

/// The normal equations of point-to-plane registration of a view with itself.
Matrix6d information(const AnalyticScene& scene, const Pinhole& camera, const SE3& pose) {
  Matrix6d sum = Matrix6d::Zero();
  double count = 0;
  for (int v = 0; v < camera.height; v += 2) {
    for (int u = 0; u < camera.width; u += 2) {
      const auto hit = scene.intersect(pose.translation(), pose.rotation() * ray_through(camera, u, v));
      if (!hit || hit->t > 4) continue;
      const Vector3d point = hit->t * ray_through(camera, u, v) - Vector3d(0, 0, 2);
      const Vector3d normal = pose.rotation().transpose() * hit->normal;
      Vector6d row;
      row << point.cross(normal), normal;
      sum += row * row.transpose();
      ++count;
    }
  }
  return sum / count;
}

TEST(DeskCorner, GeometryDeterminesAllSixDegreesOfFreedomInEveryView) {
  const AnalyticScene scene = desk_corner();
  constexpr Pinhole small{131.25f, 131.25f, 79.5f, 59.5f, 160, 120};
  const Trajectory path = orbit();
  for (std::size_t i = 0; i < path.size(); i += 10) {
    const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(information(scene, small, path[i].world_from_camera));
    EXPECT_GT(solver.eigenvalues()[0], 0.01) << "frame " << i;
    EXPECT_LT(solver.eigenvalues()[5] / solver.eigenvalues()[0], 100) << "frame " << i;
  }
}

TEST(Orbit, LooksAtTheTargetAndMovesSmoothly) {
  const OrbitOptions options;
  const Trajectory path = orbit(options);
  ASSERT_EQ(path.size(), 240U);
  EXPECT_EQ(path.front().time, options.start);
  const double dt = 1 / options.rate;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const SE3& pose = path[i].world_from_camera;
    EXPECT_NEAR(pose.rotation().determinant(), 1, 1e-12);
    const Vector3d to_target = (options.target - pose.translation()).normalized();
    EXPECT_LT(std::acos(to_target.dot(pose.rotation().col(2))), 0.05);
    EXPECT_LT(pose.rotation().col(1).z(), -0.5) << "the image is upright";
    if (i == 0) continue;
    EXPECT_EQ(path[i].time, options.start + from_seconds(static_cast<double>(i) * dt));
    const SE3 step = path[i - 1].world_from_camera.inverse() * pose;
    EXPECT_LT(step.translation().norm() / dt, 1.2);    // m/s
    EXPECT_LT(so3::angle(step.rotation()) / dt, 0.8);  // rad/s
    if (i < 2) continue;
    const Vector3d acceleration = (pose.translation() - 2 * path[i - 1].world_from_camera.translation() +
                                   path[i - 2].world_from_camera.translation()) /
                                  (dt * dt);
    EXPECT_LT(acceleration.norm(), 6);  // m/s²
  }
}

TEST(Orbit, ShakeHasTheGivenSizeAndFollowsTheSeed) {
  OrbitOptions options{.frames = 3000, .shake_translation = 0.01, .shake_rotation = 0};
  const Trajectory shaken = orbit(options), again = orbit(options);
  options.seed = 2;
  const Trajectory other = orbit(options);
  options.shake_translation = 0;
  const Trajectory still = orbit(options);
  double squares = 0, to_other = 0;
  for (std::size_t i = 0; i < shaken.size(); ++i) {
    const Vector3d& p = shaken[i].world_from_camera.translation();
    EXPECT_EQ(p, again[i].world_from_camera.translation());
    squares += (p - still[i].world_from_camera.translation()).squaredNorm() / 3;
    to_other += (p - other[i].world_from_camera.translation()).norm();
  }
  EXPECT_NEAR(std::sqrt(squares / 3000), 0.01, 0.001);
  EXPECT_GT(to_other / 3000, 0.005);
  EXPECT_THROW(orbit({.frames = 0}), Error);
}

TEST(Orbit, FewerFramesAreTheBeginningOfTheSamePath) {
  const Trajectory all = orbit(), few = orbit({.frames = 20});
  for (std::size_t i = 0; i < few.size(); ++i) {
    EXPECT_EQ(few[i].world_from_camera.translation(), all[i].world_from_camera.translation());
  }
}

TEST(LookAt, PutsTheTargetOnTheAxisWithUpAtTheTop) {
  const SE3 pose = look_at({1, 2, 3}, {-1, 0, 1});
  EXPECT_LT((pose.inverse() * Vector3d(-1, 0, 1) - Vector3d(0, 0, std::sqrt(12.0))).norm(), 1e-12);
  EXPECT_LT((pose.inverse() * Vector3d(-1, 0, 1.5)).y(), 0);
  EXPECT_THROW(look_at({1, 1, 1}, {1, 1, 1}), Error);
  EXPECT_THROW(look_at({0, 0, 1}, {0, 0, 0}), Error);
}

#if defined(NDEBUG) && !defined(__SANITIZE_ADDRESS__)
TEST(DeskCorner, RendersFasterThanFifteenFramesASecond) {
  const AnalyticScene scene = desk_corner();
  const Trajectory path = orbit({.frames = 5});
  double best = 1e9;
  for (const StampedPose& pose : path) {
    const std::clock_t start = std::clock();  // processor time: other programs do not count
    const Frame frame = render(scene, kCamera, pose.world_from_camera);
    best = std::min(best, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
    EXPECT_NE(frame.depth.at(160, 120), 0);
  }
  RecordProperty("seconds_per_frame", std::to_string(best));
  EXPECT_LT(best, 1.0 / 15);
}
#endif

}  // namespace
}  // namespace plumbline::sim
