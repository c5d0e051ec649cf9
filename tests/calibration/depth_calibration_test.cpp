// A camera that bends its depth by a known pattern looks about an analytic room.
#include "calibration/depth_calibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/random.h"
#include "plumbline/angles.h"
#include "plumbline/frame.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

using Eigen::Vector3d;

constexpr Pinhole kCamera{131.25f, 131.25f, 79.5f, 59.5f, 160, 120};
constexpr double kScale = 5000;

/// 1/m: one bump to the left and a slope, 0.0065/m rms.
double pattern(double x, double y) {
  return 0.011 * std::sin(2 * std::numbers::pi * x / 159) * std::cos(std::numbers::pi * y / 119 - 0.6) +
         0.006 * std::cos(3 * std::numbers::pi * x / 159);
}

/// In front of the corner of the desk, looking into it and somewhat down, turned by up to 25° about all axes.
SE3 pose(double t) {
  const Vector3d eye(0.8 + 0.05 * std::sin(1.3 * t), 0.8 + 0.05 * std::cos(0.9 * t), 1.4);
  const Vector3d turn(0.3 * std::sin(1.1 * t + 1), 0.4 * std::sin(0.8 * t), 0.45 * std::sin(0.6 * t + 2));
  const Eigen::Matrix3d ahead =
      so3::exp(Vector3d(0, 0, 0.75 * std::numbers::pi)) * so3::exp(Vector3d(-std::numbers::pi / 2 - 0.35, 0, 0));
  return {ahead * so3::exp(turn), eye};
}

struct Found {
  std::optional<DepthCalibrationResult> result;
  double error = 0, truth = 0;  ///< 1/m rms over the image, the error's mean apart
  double mean = 0;              ///< of the error
  double given = 0, path = 0;   ///< radians rms, of the turns of the path that was given and found, over ten frames
};

double turn_error(const Trajectory& path) {
  constexpr std::size_t kApart = 10;
  double sum = 0;
  for (std::size_t i = kApart; i < path.size(); ++i) {
    const auto truth = [&](std::size_t k) { return pose(to_seconds(path[k].time) - 0.1).rotation(); };
    const auto turn = [&](std::size_t k) -> Eigen::Matrix3d { return path[k].world_from_camera.rotation(); };
    const Eigen::Matrix3d should = truth(i - kApart).transpose() * truth(i),
                          is = turn(i - kApart).transpose() * turn(i);
    const double error = so3::angle(should.transpose() * is);
    sum += error * error;
  }
  return std::sqrt(sum / static_cast<double>(path.size() - kApart));
}

/// `bend`: factor on the pattern; `wrong`: degrees by which the path that is given errs from frame to frame.
Found calibrate(double bend, double wrong, double speed = 1, int threads = 1) {
  const std::shared_ptr<Backend> backend = make_backend("cpu", 1);
  constexpr int kFrames = 60;
  DepthCalibration calibration(kCamera, preset("kinectfusion").preprocess, *backend, kFrames);
  const sim::AnalyticScene scene = sim::desk_corner();
  Trajectory path;
  SE3 drift;
  Random random(3);
  for (int i = 0; i < kFrames; ++i) {
    const Nanoseconds time = (1 + i) * (kNanosecondsPerSecond / 10);
    const SE3 truth = pose(0.1 * i * speed);
    Frame frame = sim::render(scene, kCamera, truth, time, kScale, false);
    for (int y = 0; y < kCamera.height; ++y)
      for (int x = 0; x < kCamera.width; ++x)
        if (std::uint16_t& reading = frame.depth.at(x, y); reading != 0)
          reading = static_cast<std::uint16_t>(std::lround(kScale / (kScale / reading + bend * pattern(x, y))));
    calibration.add(frame);
    drift = SE3(so3::exp(wrong * kRadiansPerDegree * Vector3d(random.normal(), random.normal(), random.normal())),
                Vector3d::Zero()) *
            drift;
    path.push_back({time, drift * truth});
  }
  Found found{calibration.estimate(path, DepthCalibration::Tracked::as_measured, threads)};
  if (!found.result) return found;
  if (speed == 1) {
    found.given = turn_error(path);
    found.path = turn_error(found.result->path);
  }
  const DepthDistortion& d = found.result->distortion;
  double sum = 0, squares = 0, truths = 0, n = 0;
  for (int y = 0; y < kCamera.height; y += 4)
    for (int x = 0; x < kCamera.width; x += 4, ++n) {
      const double truth = bend * pattern(x, y), e = d.at(x, y) - truth;
      sum += e;
      squares += e * e;
      truths += truth * truth;
    }
  found.mean = sum / n;
  found.error = std::sqrt(squares / n - sum * sum / n / n);
  found.truth = std::sqrt(truths / n);
  return found;
}

TEST(DepthCalibration, FindsThePatternFromAPathThatErrs) {
  const Found found = calibrate(1, 0.5);
  ASSERT_TRUE(found.result);
  EXPECT_GT(found.result->pairs, 40U);
  EXPECT_GT(found.truth, 0.0059);
  EXPECT_LT(found.error, 0.25 * found.truth);
  EXPECT_LT(found.result->after, 0.7 * found.result->before);
  EXPECT_EQ(found.result->path.size(), 60U);
  EXPECT_GT(found.given, 1 * kRadiansPerDegree);
  EXPECT_LT(found.path, 0.15 * found.given);
}

TEST(DepthCalibration, HasTheSameBitsWithAnyNumberOfThreads) {
  const Found one = calibrate(1, 0.5), three = calibrate(1, 0.5, 1, 3);
  ASSERT_TRUE(one.result && three.result);
  EXPECT_EQ(one.result->distortion.values(), three.result->distortion.values());
  ASSERT_EQ(one.result->path.size(), three.result->path.size());
  for (std::size_t i = 0; i < one.result->path.size(); ++i) {
    const SE3 &a = one.result->path[i].world_from_camera, &b = three.result->path[i].world_from_camera;
    EXPECT_TRUE(a.rotation() == b.rotation() && a.translation() == b.translation()) << i;
  }
}

TEST(DepthCalibration, FindsNoneWhereThereIsNone) {
  const Found found = calibrate(0, 0.5);
  ASSERT_TRUE(found.result);
  EXPECT_LT(found.error, 0.001);
  EXPECT_LT(std::hypot(found.error, found.mean), 0.0015) << "a smaller world must not fit better";
}

TEST(DepthCalibration, SaysNothingOfACameraThatHardlyMoved) { EXPECT_FALSE(calibrate(1, 0, 0.02).result); }

TEST(DepthCalibration, FramesWithoutAPoseAreLeftOut) {
  const std::shared_ptr<Backend> backend = make_backend("cpu", 1);
  DepthCalibration calibration(kCamera, preset("kinectfusion").preprocess, *backend, 1);
  calibration.add(sim::render(sim::desk_corner(), kCamera, pose(0), 5, kScale, false));
  EXPECT_FALSE(calibration.estimate({}, DepthCalibration::Tracked::undistorted));
  EXPECT_FALSE(calibration.estimate({{7, SE3()}}, DepthCalibration::Tracked::undistorted));
}

}  // namespace
}  // namespace plumbline
