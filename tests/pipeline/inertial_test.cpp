// What a gyroscope and an accelerometer change in whole runs, on an analytic scene: good ones and broken ones.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "pipeline/runs.h"
#include "plumbline/angles.h"
#include "plumbline/config.h"
#include "plumbline/evaluation.h"
#include "plumbline/frame.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "plumbline/trajectory.h"
#include "sim/analytic_scene.h"

namespace plumbline {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const Pinhole kCamera = {131.25f, 131.25f, 79.5f, 59.5f, 160, 120};
constexpr double kFrame = 1.0 / 30;
constexpr int kFrames = 75;
const Vector3d kGravity(0.3, 9.7, 1.4);  // m/s², world

Parameters small() {
  Parameters p;
  p.volume.resolution = 160;
  p.volume.side = 3.5;
  p.volume.offset = -0.1;
  return p;
}

/// A hand in front of the desk's corner that turns by up to 60 degrees a second and moves by 10 cm to and fro.
SE3 pose_at(double t) {
  static const SE3 start = sim::orbit().front().world_from_camera;
  const Vector3d turn(0.12 * std::sin(3 * t), 0.35 * std::sin(2.7 * t), 0.08 * std::sin(4 * t));
  const Vector3d move(0.1 * std::sin(2 * t), 0.03 * std::sin(3 * t), 0.05 * std::sin(1.5 * t));
  return {start.rotation() * so3::exp(turn), start.translation() + start.rotation() * move};
}

Nanoseconds stamp(double seconds) { return from_seconds(1 + seconds); }

ImuSample reading_at(double t) {
  constexpr double h = 1e-3;
  const Matrix3d before = pose_at(t - h).rotation(), after = pose_at(t + h).rotation();
  const Vector3d acceleration =
      (pose_at(t + h).translation() - 2 * pose_at(t).translation() + pose_at(t - h).translation()) / (h * h);
  return {.time = stamp(t),
          .angular_rate = so3::log(Matrix3d(before.transpose() * after)) / (2 * h),
          .specific_force = pose_at(t).rotation().transpose() * (acceleration - kGravity)};
}

/// What a broken sensor, or its driver, makes of a reading at t seconds.
using Fault = std::function<void(double t, ImuSample* sample)>;

/// Which readings are there, by their number.
using Kept = std::function<bool(int k)>;

std::vector<ImuSample> readings_around(double t, const Fault& fault, const Kept& kept) {
  std::vector<ImuSample> readings;
  for (int k = static_cast<int>(std::ceil((t - 0.25) * 100)); k <= (t + 0.2) * 100; ++k) {
    if (kept && !kept(k)) continue;
    readings.push_back(reading_at(0.01 * k));
    if (fault) fault(0.01 * k, &readings.back());
  }
  return readings;
}

const std::vector<Frame>& images() {
  static const std::vector<Frame> frames = [] {
    std::vector<Frame> rendered;
    const sim::AnalyticScene scene = sim::desk_corner();
    for (int i = 0; i < kFrames; ++i) {
      rendered.push_back(sim::render(scene, kCamera, pose_at(i * kFrame), stamp(i * kFrame)));
      rendered.back().index = i;
    }
    return rendered;
  }();
  return frames;
}

struct Outcome {
  double ate = 0;  ///< metres
  int lost = 0, used = 0;
};

Outcome run(bool with_readings, const Fault& fault = {}, int threads = 1, const Kept& kept = {}) {
  const test::Run run = test::run_pipeline(
      small(), kCamera, kFrames,
      [&](int i) {
        Frame frame = images()[static_cast<std::size_t>(i)];
        if (with_readings) frame.inertial = readings_around(i * kFrame, fault, kept);
        return frame;
      },
      threads, pose_at(0));
  Trajectory truth;
  for (int i = 0; i < kFrames; ++i) truth.push_back({stamp(i * kFrame), pose_at(i * kFrame)});
  Outcome outcome{eval::absolute_trajectory_error(truth, run.trajectory).translation.rmse, run.lost, 0};
  for (const FrameReport& report : run.reports) outcome.used += report.orientation == OrientationUse::used;
  return outcome;
}

TEST(Inertial, AGoodSensorIsUsedAndDoesNoHarm) {
  const Outcome without = run(false), with = run(true);
  EXPECT_EQ(with.lost, 0);
  EXPECT_EQ(without.used, 0);
  EXPECT_GE(with.used, 0.98 * (kFrames - 1));
  EXPECT_LT(with.ate, 1.02 * without.ate + 0.001);
}

TEST(Inertial, AGyroscopeAloneIsUsedAndDoesNoHarm) {
  const Outcome without = run(false), with = run(true, [](double, ImuSample*s) { s->specific_force.setZero(); });
  EXPECT_EQ(with.lost, 0);
  EXPECT_GE(with.used, 0.98 * (kFrames - 1));
  EXPECT_LT(with.ate, 1.02 * without.ate + 0.001);
}

TEST(Inertial, HalfOfTheReadingsDoNoHarm) {
  const Outcome without = run(false);
  Fault fault;  // none: the readings that are there are good
  const Outcome with = run(true, fault, 1, [](int k) { return (k * k) % 7 < 3; });
  EXPECT_EQ(with.lost, 0);
  EXPECT_GE(with.used, 0.98 * (kFrames - 1));
  EXPECT_LT(with.ate, 1.02 * without.ate + 0.001);
}

TEST(Inertial, ThreadsDoNotMatter) {
  const Outcome one = run(true, {}, 1), three = run(true, {}, 3);
  EXPECT_EQ(one.ate, three.ate);
}

TEST(Inertial, ABrokenSensorDoesNoHarm) {
  const Outcome without = run(false);
  const auto rate = [](auto change) {
    return [change](double, ImuSample* s) { s->angular_rate = change(s->angular_rate); };
  };
  const struct {
    const char* name;
    Fault fault;
  } faults[] = {
      {"axes exchanged",
       [](double, ImuSample* s) {
         s->angular_rate = Vector3d(s->angular_rate.y(), s->angular_rate.z(), s->angular_rate.x());
         s->specific_force = Vector3d(s->specific_force.y(), s->specific_force.z(), s->specific_force.x());
       }},
      {"rate of the other sign", rate([](const Vector3d& w) { return Vector3d(-w); })},
      {"rate in degrees", rate([](const Vector3d& w) { return Vector3d(w * kDegreesPerRadian); })},
      {"rate a fifth of what it is", rate([](const Vector3d& w) { return Vector3d(0.2 * w); })},
      {"rate limited", rate([](const Vector3d& w) { return Vector3d(w.cwiseMax(-0.2).cwiseMin(0.2)); })},
      {"noise",
       [](double t, ImuSample* s) {
         s->angular_rate = Vector3d(std::sin(1e4 * t), std::sin(2e4 * t + 1), std::sin(3e4 * t + 2));
         s->specific_force = 9 * Vector3d(std::sin(4e4 * t), std::sin(5e4 * t + 1), std::sin(6e4 * t + 2));
       }},
      {"rate stuck at zero", rate([](const Vector3d&) { return Vector3d(0, 0, 0); })},
      {"rate stuck", rate([](const Vector3d&) { return Vector3d(0.7, -0.4, 0.5); })},
      {"readings of another second",
       [](double t, ImuSample* s) {
         const ImuSample other = reading_at(t + 1.1);
         s->angular_rate = other.angular_rate;
         s->specific_force = other.specific_force;
       }},
      {"no numbers",
       rate([](const Vector3d&) { return Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()); })},
  };
  for (const auto& [name, fault] : faults) {
    const Outcome broken = run(true, fault);
    EXPECT_EQ(broken.lost, without.lost) << name;
    EXPECT_LT(broken.ate, 1.02 * without.ate + 0.001) << name << ": used in " << broken.used << " frames";
  }
}

}  // namespace
}  // namespace plumbline
