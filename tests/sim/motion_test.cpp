// Scenes, trajectories and the sensor that rides along.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "core/random.h"
#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/mesh.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"
#include "sim/mesh_builder.h"
#include "sim/orientation_sensor.h"
#include "sim/scenes.h"
#include "sim/trajectory.h"
#include "sim/visibility.h"

namespace plumbline::sim {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

SE3 winding(double t) {
  return {so3::exp(Vector3d(0.4 * std::sin(1.3 * t), 0.8 * std::sin(0.7 * t), 0.3 * std::cos(t))),
          Vector3d(std::sin(t), 0.5 * std::cos(0.8 * t), 0.2 * std::sin(2 * t))};
}

Motion winding_motion() {
  std::vector<SE3> controls;
  for (int i = 0; i <= 200; ++i) controls.push_back(winding(0.04 * i));
  return {controls, 0.04};
}

/// Poses of the winding path at 100 Hz with a capture's jitter.
Trajectory jittered(double translation, double rotation) {
  Random random(5);
  const auto noise = [&](double sigma) -> Vector3d {
    return sigma * Vector3d(random.normal(), random.normal(), random.normal());
  };
  Trajectory poses;
  for (int i = 0; i <= 800; ++i) {
    const SE3 pose = winding(0.01 * i);
    poses.push_back(
        {10'000'000LL * i, SE3(so3::exp(noise(rotation)) * pose.rotation(), pose.translation() + noise(translation))});
  }
  return poses;
}

double signed_volume(const Mesh& mesh) {
  double sum = 0;
  for (const Mesh::Triangle& t : mesh.triangles) {
    const auto at = [&](std::uint32_t k) {
      return Vector3d(mesh.positions[k].x, mesh.positions[k].y, mesh.positions[k].z);
    };
    sum += at(t.a).dot(at(t.b).cross(at(t.c))) / 6;
  }
  return sum;
}

TEST(MeshBuilder, FormsFaceOutwards) {
  const Paint paint = plain({1, 2, 3});
  MeshBuilder box, blob, cylinder, lathe;
  box.box(turned(1, 2, 3, 0.3, 0.2, 0.1), {0.1, 0.2, 0.3}, paint);
  EXPECT_NEAR(signed_volume(box.mesh()), 8 * 0.1 * 0.2 * 0.3, 1e-5);
  blob.blob(stand(1, 0, 0), {0.3, 0.3, 0.3}, paint, 2, 60);
  EXPECT_NEAR(signed_volume(blob.mesh()), 4.0 / 3 * std::numbers::pi * 0.027, 1e-3);
  cylinder.cylinder(stand(0, 1, 0), 0.2, 0.5, paint, 64);
  EXPECT_NEAR(signed_volume(cylinder.mesh()), std::numbers::pi * 0.04 * 0.5, 1e-3);
  lathe.lathe(stand(0, 0, 1), {{0, 0}, {0.5, 0}, {0, 1}}, paint, 64);
  EXPECT_NEAR(signed_volume(lathe.mesh()), std::numbers::pi * 0.25 / 3, 2e-3);
}

TEST(Scenes, AreClosedRoomsThatEveryRayMeets) {
  for (const std::string& name : scene_names()) {
    const Scene scene = make_scene(name);
    EXPECT_GT(scene.mesh.triangles.size(), 50'000U) << name;
    EXPECT_EQ(scene.mesh.colors.size(), scene.mesh.positions.size()) << name;
    DepthCameraOptions options;
    options.camera = {66, 66, 39.5f, 29.5f, 80, 60};
    options.noise = false;
    options.depth_scale = 1000;
    const DepthCamera camera(scene.mesh, options);
    // All around from a point above the middle; the floor is left out of the corridor's and the rooms' furniture.
    const Vector3d eye = scene.focus + Vector3d(0, 0, 1.0);
    for (int turn = 0; turn < 6; ++turn) {
      const Matrix3d level = (Eigen::AngleAxisd(turn * std::numbers::pi / 3, Vector3d::UnitZ()) *
                              Eigen::AngleAxisd(-std::numbers::pi / 2, Vector3d::UnitX()))
                                 .toRotationMatrix();
      for (const std::uint16_t reading : camera.capture(SE3(level, eye), 0).depth.pixels) ASSERT_NE(reading, 0) << name;
    }
  }
}

TEST(Scenes, AreTheSameEveryTime) {
  const Scene a = make_scene("kitchen"), b = make_scene("kitchen");
  ASSERT_EQ(a.mesh.positions.size(), b.mesh.positions.size());
  for (std::size_t i = 0; i < a.mesh.positions.size(); ++i) ASSERT_EQ(a.mesh.positions[i].x, b.mesh.positions[i].x);
  EXPECT_THROW(make_scene("attic"), Error);
  EXPECT_THROW(scene_of("empty", Mesh{}), Error);
}

TEST(Motion, IsTwiceDifferentiableAcrossItsKnots) {
  const Motion motion = winding_motion();
  constexpr double kStep = 1e-4;
  const auto acceleration = [&](double t) {
    return Vector3d(
        (motion.at(t - kStep).translation() - 2 * motion.at(t).translation() + motion.at(t + kStep).translation()) /
        (kStep * kStep));
  };
  for (const double knot : {0.4, 1.2, 4.0}) {
    EXPECT_LT((acceleration(knot - 2 * kStep) - acceleration(knot + 2 * kStep)).norm(), 0.05);
    EXPECT_LT((motion.at(knot - 1e-9).translation() - motion.at(knot + 1e-9).translation()).norm(), 1e-7);
  }
  EXPECT_LT((motion.at(3).translation() - winding(3).translation()).norm(), 1e-3);
  EXPECT_LT((motion.faster(2).at(1.5).translation() - motion.at(3).translation()).norm(), 1e-12);
  EXPECT_NEAR(motion.faster(4).duration(), motion.duration() / 4, 1e-12);
  EXPECT_THROW(motion.faster(0), Error);
}

TEST(Motion, SmoothingTakesTheJitterAndLeavesTheMotion) {
  Smoothing lost;
  const Motion motion = smooth_motion(jittered(0.001, 0.002), 0.06, &lost);
  double translation = 0, rotation = 0;
  for (int i = 20; i < 780; ++i) {
    const SE3 pose = motion.at(0.01 * i), truth = winding(0.01 * i);
    translation += (pose.translation() - truth.translation()).squaredNorm() / 760;
    rotation += std::pow(so3::angle(pose.rotation().transpose() * truth.rotation()), 2) / 760;
  }
  EXPECT_LT(std::sqrt(translation), 0.0012);  // of 1.7 mm
  EXPECT_LT(std::sqrt(rotation), 0.0024);     // of 3.5 mrad
  EXPECT_NEAR(lost.translation_rms, 0.001 * std::sqrt(3.0), 3e-4);
  EXPECT_THROW(smooth_motion(Trajectory(3)), Error);
}

TEST(Motion, GapsOfTheCaptureAreCrossedOnTheStraightWay) {
  Trajectory poses = jittered(0, 0);
  poses.erase(poses.begin() + 300, poses.begin() + 500);
  Smoothing lost;
  const Motion motion = smooth_motion(poses, 0.06, &lost);
  EXPECT_NEAR(lost.longest_gap, 2.01, 0.001);
  const Vector3d a = winding(3).translation(), b = winding(5).translation();
  EXPECT_LT((motion.at(4).translation() - (a + b) / 2).norm(), 0.02);
}

TEST(Paths, StayInTheirScenes) {
  for (const char* scene_name : {"desk", "room", "kitchen", "teddy"}) {
    const Scene scene = make_scene(scene_name);
    for (const std::string& kind : path_kinds()) {
      const Motion motion = make_path(kind, scene, {});
      const Placement placement = judge(motion, scene, SE3());
      EXPECT_GT(placement.share_in_range, kind == "orbit" || kind == "handheld" ? 0.5 : 0.2)
          << scene_name << " " << kind;
      EXPECT_EQ(make_path(kind, scene, {}).at(1.7).translation(), motion.at(1.7).translation());
    }
  }
  EXPECT_THROW(make_path("spiral", make_scene("corridor"), {}), Error);
}

TEST(Placement, KeepsClearOfSurfacesAndUpright) {
  const Scene scene = make_scene("desk");
  // About a metre across, looking along the floor and about.
  std::vector<SE3> controls;
  const Matrix3d level = so3::exp(Vector3d(-std::numbers::pi / 2, 0, 0));
  for (int i = 0; i < 100; ++i)
    controls.emplace_back(level * winding(0.08 * i).rotation(), 0.4 * winding(0.08 * i).translation());
  const Placement found = place(Motion(controls, 0.08), scene, 0.25);
  EXPECT_GE(found.clearance, 0.25);
  EXPECT_GT((found.scene_from_recorded.rotation() * Vector3d::UnitZ()).z(), 1 - 1e-12);
  const Motion through_the_wall(
      {SE3(Matrix3d::Identity(), Vector3d(0, 0, 1.6)), SE3(Matrix3d::Identity(), Vector3d(50, 0, 1.6))}, 1);
  EXPECT_THROW(place(through_the_wall, scene), Error);
}

TEST(TurnPairs, TurnOnTheSpot) {
  const double angle = 25 * kRadiansPerDegree;
  for (const TurnAxis axis : {TurnAxis::pan, TurnAxis::any}) {
    const TurnPairs pairs(winding_motion(), angle, axis, 30, 3);
    for (int k = 0; k < 20; ++k) {
      const SE3 a = pairs.at(2 * k / 30.0), b = pairs.at((2 * k + 1) / 30.0);
      EXPECT_LT((a.translation() - b.translation()).norm(), 1e-9);
      EXPECT_NEAR(so3::angle(a.rotation().transpose() * b.rotation()), angle, 1e-6);
      EXPECT_LT((a.translation() - winding_motion().at(2 * k / 30.0).translation()).norm(), 1e-9);
    }
  }
}

TEST(TurnPairs, PanToTheLeftAndToTheRight) {
  const double angle = 25 * kRadiansPerDegree;
  const TurnPairs pairs(winding_motion(), angle, TurnAxis::pan, 30, 3);
  int right = 0;
  for (int k = 0; k < 40; ++k) {
    const Vector3d turn =
        so3::log(pairs.at(2 * k / 30.0).rotation().transpose() * pairs.at((2 * k + 1) / 30.0).rotation());
    EXPECT_LT((turn.cwiseAbs() - angle * Vector3d::UnitY()).norm(), 1e-6);
    right += turn.y() > 0;
  }
  EXPECT_GT(right, 5);
  EXPECT_LT(right, 35);
}

TEST(Sensor, IntegratedGyroscopeGivesTheOrientation) {
  OrientationSensorOptions options;
  options.rate = 500;
  options.body_from_camera = so3::exp(Vector3d(0.3, -1.2, 0.7));
  options.lever_arm = {0.05, -0.1, 0.02};
  const Motion motion = winding_motion();
  const auto samples = simulate_sensor([&](double t) { return motion.at(t); }, motion.duration(), 0, options);
  Matrix3d r = samples.front().earth_from_body;
  for (std::size_t i = 1; i < samples.size(); ++i)
    r = r * so3::exp((samples[i - 1].angular_rate + samples[i].angular_rate) / (2 * options.rate));
  EXPECT_LT(so3::angle(r.transpose() * samples.back().earth_from_body), 1e-3);
  EXPECT_GT(so3::angle(samples.front().earth_from_body.transpose() * samples[2000].earth_from_body), 0.1);
}

TEST(Sensor, AccelerometerWithoutTheMotionIsGravityAndTheLeverArmIsFelt) {
  OrientationSensorOptions options;
  options.body_from_camera = so3::exp(Vector3d(0.2, 0.1, -0.4));
  options.lever_arm = {0.3, 0, 0.1};
  const Motion motion = winding_motion();
  const PoseAt at = [&](double t) { return motion.at(t); };
  const auto samples = simulate_sensor(at, motion.duration(), 0, options);
  const auto sensor = [&](double t) { return Vector3d(motion.at(t) * Vector3d(0.3, 0, 0.1)); };
  options.lever_arm.setZero();
  const auto at_camera = simulate_sensor(at, motion.duration(), 0, options);
  double lever = 0;
  for (const std::size_t i : {100U, 333U, 700U}) {
    const double t = to_seconds(samples[i].time), h = 2e-3;
    const Vector3d acceleration = (sensor(t - h) - 2 * sensor(t) + sensor(t + h)) / (h * h);
    const Vector3d gravity = samples[i].earth_from_body * samples[i].specific_force - acceleration;
    EXPECT_LT((gravity - Vector3d(0, 0, kGravity)).norm(), 0.03);
    // ω̇ × r + ω × (ω × r), with ω from the gyroscope.
    const Vector3d rate = samples[i].angular_rate, r = options.body_from_camera * Vector3d(0.3, 0, 0.1);
    const Vector3d change = (samples[i + 1].angular_rate - samples[i - 1].angular_rate) / 0.02;
    const Vector3d felt = samples[i].specific_force - at_camera[i].specific_force;
    EXPECT_LT((felt - (change.cross(r) + rate.cross(rate.cross(r)))).norm(), 0.02);
    lever = std::max(lever, felt.norm());
    EXPECT_LT((samples[i].earth_from_body * samples[i].magnetic_field - earth_magnetic_field()).norm(), 1e-9);
  }
  EXPECT_GT(lever, 0.02);
}

TEST(Sensor, ClockLatencyAndDisturbance) {
  const PoseAt still = [](double) { return SE3(); };
  OrientationSensorOptions options;
  options.rate = 50;
  options.latency = 0.04;
  options.clock_offset = 0.5;
  options.clock_drift = 1e-3;
  const auto late = simulate_sensor(still, 10, kNanosecondsPerSecond, options);
  EXPECT_LE(late.front().time, kNanosecondsPerSecond + from_seconds(0.02));
  // The reading of t = 10 s.
  EXPECT_NEAR(to_seconds(late.back().time), 1 + 10 + 0.04 + 0.5 + 1e-3 * 10.04, 1e-6);

  options = {};
  options.disturbance = {20, 0, 0};  // as strong as the earth's, to the east: the needle turns by 45° to the right
  options.disturbance_begin = 3;
  options.disturbance_end = 6;
  const auto samples = simulate_sensor(still, 10, 0, options);
  EXPECT_LT(so3::angle(samples[100].earth_from_body), 1e-12);
  EXPECT_LT((so3::log(samples[450].earth_from_body) - Vector3d(0, 0, 45 * kRadiansPerDegree)).norm(), 1e-9);
  EXPECT_LT((samples[450].magnetic_field - Vector3d(20, 20, -44)).norm(), 1e-9);
  EXPECT_LT(so3::angle(samples[800].earth_from_body), 1e-12);
  options.rate = 0;
  EXPECT_THROW(simulate_sensor(still, 1, 0, options), Error);
}

TEST(Sensor, NoiseHasTheGivenSizeAndRepeatsWithTheSeed) {
  const PoseAt still = [](double) { return SE3(); };
  OrientationSensorOptions options;
  options.gyroscope_noise = 0.01;
  options.accelerometer_noise = 0.2;
  const auto a = simulate_sensor(still, 100, 0, options), b = simulate_sensor(still, 100, 0, options);
  double gyroscope = 0, accelerometer = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].angular_rate, b[i].angular_rate);
    gyroscope += a[i].angular_rate.squaredNorm() / 3;
    accelerometer += (a[i].specific_force - Vector3d(0, 0, kGravity)).squaredNorm() / 3;
  }
  EXPECT_NEAR(std::sqrt(gyroscope / static_cast<double>(a.size())), 0.01, 2e-4);
  EXPECT_NEAR(std::sqrt(accelerometer / static_cast<double>(a.size())), 0.2, 4e-3);
}

TEST(Visibility, APointBehindASurfaceIsNotSeen) {
  MeshBuilder m;
  m.box(stand(0, 0, 1), {0.5, 0.5, 0.05}, plain({1, 1, 1}));
  m.box(stand(0, 0, 2), {3, 3, 0.05}, plain({1, 1, 1}));
  const std::vector<Mesh::Float3> points = {{0, 0, 0.95f}, {0, 0, 1.95f}, {1.1f, 0, 1.95f}, {5, 0, 1.95f}};
  const Trajectory poses = {{0, SE3()}};
  const std::vector<bool> seen = seen_points(m.mesh(), points, {100, 100, 99.5f, 99.5f, 200, 200}, poses, 0.4, 4);
  EXPECT_EQ(seen, (std::vector<bool>{true, false, true, false}));
}

}  // namespace
}  // namespace plumbline::sim
