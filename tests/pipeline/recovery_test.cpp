// After an interruption: a known place is recognised, a foreign one refused, and nothing is fused before other views of
// the place have confirmed it (docs/method.md §9).
#include <gtest/gtest.h>

#include <optional>

#include "map/volume.h"
#include "pipeline/runs.h"
#include "place/relocaliser.h"
#include "plumbline/frame.h"
#include "plumbline/pinhole.h"
#include "plumbline/pipeline.h"
#include "plumbline/se3.h"
#include "plumbline/trajectory.h"
#include "sim/analytic_scene.h"
#include "support/scenes.h"
#include "tracking/live_frame.h"

namespace plumbline {
namespace {

const Pinhole kCamera = test::pinhole(160, 120);
constexpr int kMapped = 150;  // frames, 5 s: from the middle of the arc to one end and back

/// A room with none of the desk's shapes.
sim::AnalyticScene another_room() {
  sim::AnalyticScene scene;
  scene.primitives = {sim::plane({0, 0, 0}, {0, 0, 1}), sim::plane({-1.8, 0, 0}, {1, 0.3, 0}),
                      sim::sphere({-0.6, 0.3, 0.5}, 0.5), sim::sphere({0.1, -0.9, 0.9}, 0.3),
                      sim::cylinder(SE3(Eigen::Matrix3d::Identity(), {-1, -1, 0.7}), 0.25, 0.7)};
  return scene;
}

class RecoveryTest : public testing::Test {
 protected:
  Frame frame(int i) const { return at(path_[static_cast<std::size_t>(i)].world_from_camera, time_of(i)); }
  Frame at(const SE3& pose, Nanoseconds time) const { return sim::render(scene_, kCamera, pose, time, 5000, false); }
  static Nanoseconds time_of(int i) { return from_seconds(1 + i / 30.0); }
  static Frame covered(int i) {
    Frame frame;
    frame.time = time_of(i);
    frame.depth = DepthImage(kCamera.width, kCamera.height);
    return frame;
  }
  const SE3& truth(int i) const { return path_[static_cast<std::size_t>(i)].world_from_camera; }

  void map() {
    for (int i = 0; i < kMapped; ++i) ASSERT_TRUE(has_pose(pipeline_.process(frame(i)).tracking.status)) << i;
  }
  static double error(const SE3& a, const SE3& b) { return (a.translation() - b.translation()).norm(); }

  sim::AnalyticScene scene_ = sim::desk_corner();
  Trajectory path_ = sim::orbit({.period = 10, .frames = 300});
  std::shared_ptr<Backend> backend_ = make_backend("cpu", 2);
  Pipeline pipeline_{test::parameters_for_quarter_size(), kCamera, *backend_, path_.front().world_from_camera};
};

TEST_F(RecoveryTest, ACameraThatWasCoveredFindsItselfElsewhere) {
  map();
  int next = kMapped;
  for (; next < kMapped + 30; ++next) EXPECT_EQ(pipeline_.process(covered(next)).tracking.reason, LostReason::no_depth);
  // It comes back at the end of the arc, where it was 3 s ago.
  const int shift = next - 75;
  ASSERT_GT(error(truth(kMapped - 1), truth(75)), 0.8);
  int recovered = -1, provisional = 0, tracked = 0;
  const Mesh before = pipeline_.extract_mesh();
  for (; next < kMapped + 90; ++next) {
    const FrameReport report = pipeline_.process(at(truth(next - shift), time_of(next)));
    if (report.is_recovered) recovered = next;
    provisional += report.tracking.status == TrackingStatus::provisional;
    tracked += report.tracking.status == TrackingStatus::tracked;
    if (report.tracking.status == TrackingStatus::lost) continue;
    EXPECT_LT(error(report.world_from_camera, truth(next - shift)), 0.02) << next;
    if (report.tracking.status != TrackingStatus::provisional) continue;
    EXPECT_EQ(report.milliseconds.integrate, 0) << "not fused while on trial";
    ASSERT_EQ(pipeline_.extract_mesh().positions.size(), before.positions.size());
  }
  EXPECT_GE(recovered, kMapped + 30);
  EXPECT_LE(recovered, kMapped + 40);
  EXPECT_GE(provisional, 1);
  EXPECT_LE(provisional, 31);
  EXPECT_GT(tracked, 15);
}

TEST_F(RecoveryTest, AForeignPlaceIsRefusedAndChangesNothing) {
  map();
  const Mesh before = pipeline_.extract_mesh();
  scene_ = another_room();
  for (int i = kMapped + 30; i < kMapped + 80; ++i) {
    const FrameReport report = pipeline_.process(frame(i));
    EXPECT_EQ(report.tracking.status, TrackingStatus::lost) << i;
    EXPECT_TRUE(report.is_after_interruption);
    EXPECT_EQ(report.tracking.reason, LostReason::unknown_place);
  }
  EXPECT_EQ(pipeline_.extract_mesh().positions.size(), before.positions.size());
  // And the old place is recognised after all that.
  scene_ = sim::desk_corner();
  bool is_recovered = false;
  for (int i = kMapped + 80; i < kMapped + 100; ++i) is_recovered |= pipeline_.process(frame(i)).is_recovered;
  EXPECT_TRUE(is_recovered);
}

// What looks the same stands elsewhere in most buildings.
TEST_F(RecoveryTest, APlaceFartherThanTheCameraCanHaveGoneIsNotConsidered) {
  const Parameters parameters = test::parameters_for_quarter_size();
  LiveFrame live(kCamera, parameters.preprocess, pyramid_levels(parameters.tracking), *backend_, false,
                 parameters.tracking.finest_level);
  live.prepare(frame(0));
  Volume volume(parameters.volume, kCamera, *backend_, false);
  volume.place(place_volume(parameters.volume, kCamera, truth(0), download(*backend_, live.raw_depth())));
  volume.integrate(live.raw_depth(), nullptr, kCamera, truth(0));
  Relocaliser relocaliser(parameters, kCamera, *backend_, [&](const Viewpoint& from, DepthPyramid* levels) {
    volume.visit(from);
    volume.predict(from.world_from_camera, raycast_range(parameters.preprocess.max_depth), levels);
  });
  relocaliser.remember({live.pyramid(), std::nullopt}, {truth(0)});
  PlaceQuery query{{live.pyramid(), std::nullopt}, {}, {}};
  query.previous = {truth(0) * SE3(Eigen::Matrix3d::Identity(), {5, 0, 0})};
  query.reach = 4;
  const Relocaliser::Search refused = relocaliser.find(query);
  EXPECT_FALSE(refused.place);
  EXPECT_EQ(refused.starts, 0);
  query.reach = 6;
  const Relocaliser::Search found = relocaliser.find(query);
  ASSERT_TRUE(found.place);
  EXPECT_LT(error(found.place->evidence.result.world_from_camera, truth(0)), 0.01);
}

TEST_F(RecoveryTest, AGapIsJudgedByTheUsualInterval) {
  // Every 15th frame: half a second apart is usual here, and two of them missing are an interruption.
  const auto step = [&](int i) { return pipeline_.process(at(truth(i / 5), time_of(i))); };
  for (int i = 0; i <= 90; i += 15) EXPECT_FALSE(step(i).is_after_interruption) << i;
  EXPECT_FALSE(step(120).is_after_interruption);
  EXPECT_TRUE(step(165).is_after_interruption);
}

TEST_F(RecoveryTest, AMomentWithoutDepthIsNoInterruption) {
  map();
  for (int i = kMapped; i < kMapped + 5; ++i) pipeline_.process(covered(i));
  const FrameReport report = pipeline_.process(frame(kMapped + 5));
  EXPECT_EQ(report.tracking.status, TrackingStatus::tracked);
  EXPECT_FALSE(report.is_after_interruption);
}

TEST_F(RecoveryTest, OneKeyframeIsEnough) {
  pipeline_.process(frame(0));
  pipeline_.process(frame(1));
  bool is_recovered = false;
  for (int i = 60; i < 70; ++i) is_recovered |= pipeline_.process(at(truth(2), time_of(i))).is_recovered;
  EXPECT_TRUE(is_recovered);
}

TEST_F(RecoveryTest, SwitchedOffAFrameAfterAGapIsTakenByTheUsualTests) {
  Parameters parameters = test::parameters_for_quarter_size();
  parameters.tracking.relocalise_after = 0;
  Pipeline pipeline(parameters, kCamera, *backend_, truth(0));
  for (int i = 0; i < 30; ++i) pipeline.process(frame(i));
  const FrameReport report = pipeline.process(at(truth(30), time_of(45)));
  EXPECT_EQ(report.tracking.status, TrackingStatus::tracked);
  EXPECT_FALSE(report.is_after_interruption);
}

TEST_F(RecoveryTest, RepeatsToTheBitWithAnyNumberOfThreads) {
  const auto run = [&](int threads) {
    return test::run_pipeline(
        test::parameters_for_quarter_size(), kCamera, 120,
        [&](int i) { return at(truth(i), time_of(i < 90 ? i : i + 60)); }, threads, truth(0));
  };
  const test::Run one = run(1), four = run(4);
  ASSERT_EQ(one.reports.size(), four.reports.size());
  bool is_recovered = false;
  for (std::size_t i = 0; i < one.reports.size(); ++i) {
    is_recovered |= one.reports[i].is_recovered;
    EXPECT_EQ(one.reports[i].tracking.status, four.reports[i].tracking.status) << i;
    EXPECT_EQ(one.reports[i].world_from_camera.translation(), four.reports[i].world_from_camera.translation()) << i;
    EXPECT_EQ(one.reports[i].world_from_camera.rotation(), four.reports[i].world_from_camera.rotation()) << i;
  }
  EXPECT_TRUE(is_recovered);
}

}  // namespace
}  // namespace plumbline
