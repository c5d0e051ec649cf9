// Real sequences over all their frames. The figures are bounds for CI; the measured ones stand in docs/results.md.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "io/trajectory.h"
#include "pipeline/runs.h"
#include "plumbline/evaluation.h"
#include "plumbline/frame.h"
#include "plumbline/orientation.h"
#include "plumbline/orientation_stream.h"
#include "plumbline/se3.h"
#include "plumbline/sequence.h"
#include "plumbline/statistics.h"
#include "plumbline/surface_error.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"
#include "sensor/error_model.h"
#include "support/data.h"

namespace plumbline {
namespace {

test::Run run(const Sequence& sequence, const Parameters& parameters, const SE3& initial_pose = SE3()) {
  return test::run_pipeline(
      parameters, sequence.info().camera, sequence.size(), [&](int i) { return sequence.read(i); }, 0, initial_pose);
}

double ate(const Sequence& sequence, const test::Run& result) {
  return eval::absolute_trajectory_error(read_trajectory(sequence.info().groundtruth), result.trajectory)
      .translation.rmse;
}

TEST(RealSequence, Freiburg1XyzIsTrackedWhole) {
  PLUMBLINE_DATA_OR_SKIP(folder, "tum/rgbd_dataset_freiburg1_xyz");
  const auto sequence = open_sequence(folder.string(), {});
  const test::Run result = run(*sequence, preset("kinectfusion"));
  EXPECT_EQ(result.lost, 0);
  EXPECT_EQ(result.trajectory.size(), 798u);
  EXPECT_LE(ate(*sequence, result), 0.022);
  EXPECT_GT(result.mesh.triangles.size(), 100000u);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  EXPECT_LE(usage.ru_maxrss / 1024, 700) << "peak memory in MiB";
}

TEST(RealSequence, Freiburg1RpyHeadFromInsideALargeVolume) {
  PLUMBLINE_DATA_OR_SKIP(folder, "tum/rgbd_dataset_freiburg1_rpy_head");
  const auto sequence = open_sequence(folder.string(), {});
  Parameters parameters = preset("kinectfusion");
  parameters.volume.side = 6;
  parameters.volume.offset = -0.4;
  const test::Run result = run(*sequence, parameters);
  EXPECT_LE(result.lost, 12) << "frames 39 to 56 look at almost nothing";
  EXPECT_LE(ate(*sequence, result), 0.09);
}

/// Frames with the ground truth's orientation as a sensor with a chip's error would have read it.
test::Run run_with_chip(const Sequence& sequence, std::uint64_t seed, int stride) {
  std::vector<OrientationSample> samples;
  for (const StampedPose& pose : read_trajectory(sequence.info().groundtruth))
    samples.push_back({pose.time, pose.world_from_camera.rotation()});
  OrientationErrorModel model = error_model("bno055");
  model.seed = seed;
  OrientationStreamOptions options;
  options.max_gap = 0.5;
  const OrientationStream stream(with_error(model, std::move(samples)), options);
  const auto frame = [&](int i) {
    Frame f = sequence.read(i * stride);
    const OrientationReading reading = stream.lookup(f.time);
    if (reading.status == OrientationStatus::ok) f.earth_from_camera = reading.earth_from_camera;
    return f;
  };
  return test::run_pipeline(preset("plumbline"), sequence.info().camera, sequence.size() / stride, frame);
}

TEST(RealSequence, Freiburg1XyzWithOurPreset) {
  PLUMBLINE_DATA_OR_SKIP(folder, "tum/rgbd_dataset_freiburg1_xyz");
  const auto sequence = open_sequence(folder.string(), {});
  const test::Run result = run(*sequence, preset("plumbline"));
  EXPECT_EQ(result.lost, 0);
  EXPECT_LE(ate(*sequence, result), 0.014);
}

TEST(RealSequence, Freiburg1RpyHeadWithOurPresetAndNoSensor) {
  PLUMBLINE_DATA_OR_SKIP(folder, "tum/rgbd_dataset_freiburg1_rpy_head");
  const auto sequence = open_sequence(folder.string(), {});
  for (const int stride : {1, 3}) {
    const test::Run result = test::run_pipeline(preset("plumbline"), sequence->info().camera, sequence->size() / stride,
                                                [&](int i) { return sequence->read(i * stride); });
    EXPECT_EQ(result.lost, 0) << "every " << stride << ". frame";
    EXPECT_LE(ate(*sequence, result), 0.04) << "every " << stride << ". frame: the baseline loses 61 of 80";
  }
}

TEST(RealSequence, EveryFourthFrameOfFreiburg1Xyz) {
  PLUMBLINE_DATA_OR_SKIP(folder, "tum/rgbd_dataset_freiburg1_xyz");
  const auto sequence = open_sequence(folder.string(), {});
  const test::Run result = test::run_pipeline(preset("plumbline"), sequence->info().camera, sequence->size() / 4,
                                              [&](int i) { return sequence->read(i * 4); });
  EXPECT_EQ(result.lost, 0);
  EXPECT_LE(ate(*sequence, result), 0.02) << "0.103 m with a fixed number of iterations";
}

TEST(RealSequence, Freiburg1RpyHeadWithAnOrientationSensor) {
  PLUMBLINE_DATA_OR_SKIP(folder, "tum/rgbd_dataset_freiburg1_rpy_head");
  const auto sequence = open_sequence(folder.string(), {});
  for (const int stride : {1, 3}) {
    const test::Run result = run_with_chip(*sequence, 1, stride);
    EXPECT_EQ(result.lost, 0) << "every " << stride << ". frame";
    EXPECT_LE(ate(*sequence, result), 0.04) << "every " << stride << ". frame";
  }
}

TEST(RealSequence, IclOfficeTrajectoryAndSurface) {
  PLUMBLINE_DATA_OR_SKIP(folder, "icl_nuim/office_kt3");
  const auto sequence = open_sequence(folder.string(), {});
  const Trajectory truth = read_trajectory(sequence->info().groundtruth);
  const auto pose_at = [&](Nanoseconds time) {
    for (const StampedPose& pose : truth) {
      if (pose.time == time) return pose.world_from_camera;
    }
    ADD_FAILURE() << "no exact pose at " << time;
    return SE3();
  };
  const test::Run result = run(*sequence, preset("kinectfusion"), pose_at(sequence->time(0)));
  EXPECT_EQ(result.lost, 0);
  EXPECT_LE(ate(*sequence, result), 0.010);

  eval::PointCloud reference;
  for (int i = 0; i < sequence->size(); i += 5) {
    const Frame frame = sequence->read(i);
    const auto points = eval::back_project(frame, sequence->info().camera, pose_at(frame.time), 2);
    reference.insert(reference.end(), points.begin(), points.end());
  }
  const eval::Statistics error = eval::statistics(eval::distances_to_points(result.mesh.positions, reference));
  EXPECT_LE(error.mean, 0.008);
  RecordProperty("mean_surface_distance_mm", std::to_string(1e3 * error.mean));
}

}  // namespace
}  // namespace plumbline
