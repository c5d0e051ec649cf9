// Simulated recordings with random mountings, offsets, sensors and trackers' errors.
#include "calibration/mounting_calibration.h"

#include <gmock/gmock.h>

#include <Eigen/Dense>

#include "calibration/simulated_recording.h"
#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/orientation.h"
#include "plumbline/se3.h"

namespace plumbline {
namespace {

using Eigen::Vector3d;
using test::record;
using test::Recording;
using test::RecordingOptions;
using testing::HasSubstr;

struct Outcome {
  double worst_mounting = 0, worst_offset = 0;  // degrees, milliseconds
  double worst_closed_form = 0;                 // degrees
  double consistency = 0;                       // mean of εᵀ Σ⁻¹ ε / 3 of the mounting: 1 if Σ is right
  int good = 0;
};

Outcome calibrate(RecordingOptions options, int cases) {
  Outcome out;
  for (int i = 1; i <= cases; ++i) {
    options.seed = static_cast<std::uint64_t>(i);
    const Recording r = record(options);
    const MountingCalibration c = calibrate_mounting(r.camera, r.stream());
    EXPECT_EQ(c.advice.empty(), c.verdict == MotionVerdict::good);
    const Vector3d error = so3::log(c.body_from_camera.transpose() * r.body_from_camera);
    out.worst_mounting = std::max(out.worst_mounting, error.norm() / kRadiansPerDegree);
    out.worst_offset = std::max(out.worst_offset, 1e3 * std::abs(c.time_offset - r.time_offset));
    out.worst_closed_form =
        std::max(out.worst_closed_form, so3::angle(c.park_martin.transpose() * r.body_from_camera) / kRadiansPerDegree);
    out.consistency += error.dot(c.covariance.inverse() * error) / 3 / cases;
    out.good += c.verdict == MotionVerdict::good;
  }
  return out;
}

int poor(const RecordingOptions& options, int cases) { return cases - calibrate(options, cases).good; }

TEST(MountingCalibration, FindsMountingAndOffsetOfAChipThatErrs) {
  const Outcome out = calibrate({}, 20);
  EXPECT_EQ(out.good, 20);
  EXPECT_LT(out.worst_mounting, 0.5);
  EXPECT_LT(out.worst_offset, 3);
  EXPECT_GT(out.worst_closed_form, 2) << "the error model must matter, or this shows nothing";
  EXPECT_GT(out.consistency, 0.3);
  EXPECT_LT(out.consistency, 3);
}

TEST(MountingCalibration, AnIdealSensorLeavesTheTrackersError) {
  const Outcome out = calibrate({.ideal = true}, 10);
  EXPECT_EQ(out.good, 10);
  EXPECT_LT(out.worst_mounting, 0.3);
  EXPECT_LT(out.worst_offset, 3);
  EXPECT_LT(out.consistency, 3);
  const Outcome exact = calibrate({.ideal = true, .exact_poses = true}, 5);
  EXPECT_LT(exact.worst_mounting, 0.01);
  EXPECT_LT(exact.worst_offset, 0.1);
}

/// An error with more harmonics than the calibration knows of.
TEST(MountingCalibration, AnErrorOfAnotherFormIsStillFound) {
  const Outcome out = calibrate({.harmonics = 5}, 10);
  EXPECT_GE(out.good, 9);
  EXPECT_LT(out.worst_mounting, 0.6);
  EXPECT_LT(out.worst_offset, 3);
}

TEST(MountingCalibration, PoorMotionIsNoticed) {
  for (const bool ideal : {false, true}) {
    EXPECT_EQ(poor({.reach = Vector3d::Zero(), .ideal = ideal}, 3), 3) << "held still";
    EXPECT_EQ(poor({.reach = Vector3d::Zero(), .tremor = 0, .ideal = ideal}, 3), 3) << "on a tripod";
    EXPECT_EQ(poor({.reach = Vector3d(40, 0, 0), .ideal = ideal}, 3), 3) << "nodding only";
    EXPECT_EQ(poor({.reach = Vector3d(0, 60, 0), .ideal = ideal}, 3), 3) << "panning only";
    EXPECT_EQ(poor({.reach = Vector3d(0, 0, 60), .ideal = ideal}, 3), 3) << "rolling only";
    EXPECT_EQ(poor({.tempo = 0.1, .ideal = ideal}, 3), 3) << "too slow";
    EXPECT_EQ(poor({.duration = 1.8, .ideal = ideal}, 3), 3) << "too short";
  }
}

TEST(MountingCalibration, SaysWhatIsWrongWithTheMotion) {
  const auto run = [](const RecordingOptions& options) {
    const Recording r = record(options);
    return calibrate_mounting(r.camera, r.stream());
  };
  const MountingCalibration pan = run({.reach = Vector3d(0, 60, 0)});
  EXPECT_EQ(pan.verdict, MotionVerdict::one_axis);
  EXPECT_THAT(pan.advice, HasSubstr("about one axis only"));
  EXPECT_THAT(pan.advice, HasSubstr("about y (left and right)"));
  EXPECT_EQ(run({.duration = 1.5}).verdict, MotionVerdict::too_short);
  EXPECT_EQ(run({.reach = Vector3d::Zero()}).verdict, MotionVerdict::no_rotation);
  // What a turn about one axis leaves open is the mounting about that axis.
  EXPECT_GT(pan.sd_along()[2], 1.5 * pan.sd_along()[1]);
  EXPECT_GT(std::abs(pan.worst_axis().y()), 0.9);
}

TEST(MountingCalibration, AnotherRecordingDoesNotFit) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Recording r = record({.seed = seed});
    r.sensor = record({.seed = seed + 100}).sensor;
    EXPECT_NE(calibrate_mounting(r.camera, r.stream()).verdict, MotionVerdict::good) << seed;
  }
  Recording r = record({});
  for (OrientationSample& s : r.sensor) s.time += 1000 * kNanosecondsPerSecond;
  EXPECT_THROW(calibrate_mounting(r.camera, r.stream()), Error);
}

TEST(MountingCalibration, LostFramesAndWrongPosesAreBorne) {
  Recording r = record({.seed = 7, .duration = 12});
  r.camera.erase(r.camera.begin() + 100, r.camera.begin() + 130);
  for (std::size_t i = 200; i < 206; ++i)
    r.camera[i].world_from_camera =
        SE3(so3::exp(Vector3d(0.2, 0.1, -0.1)), Vector3d::Zero()) * r.camera[i].world_from_camera;
  const MountingCalibration c = calibrate_mounting(r.camera, r.stream());
  EXPECT_LT(so3::angle(c.body_from_camera.transpose() * r.body_from_camera), 0.5 * kRadiansPerDegree);
  EXPECT_NEAR(c.time_offset, r.time_offset, 0.003);
}

}  // namespace
}  // namespace plumbline
