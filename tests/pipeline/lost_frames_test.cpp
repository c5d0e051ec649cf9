// The pipeline around the tracker: what a lost frame leaves behind, and how each pixel's use is told.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "kernels/icp.h"
#include "plumbline/error.h"
#include "plumbline/frame.h"
#include "plumbline/image.h"
#include "plumbline/mesh.h"
#include "plumbline/pinhole.h"
#include "plumbline/pipeline.h"
#include "plumbline/se3.h"
#include "plumbline/trajectory.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

constexpr int kFrames = 10;

Parameters small_parameters() {
  Parameters parameters = preset("kinectfusion");
  parameters.volume.resolution = 128;
  parameters.volume.side = 3.2;
  parameters.volume.truncation = 0.06;
  return parameters;
}

struct Scan {
  Pinhole camera = test::pinhole(160, 120);
  Trajectory truth = sim::orbit();
  std::vector<Frame> frames;

  Scan() {
    const sim::AnalyticScene scene = sim::desk_corner();
    for (int i = 0; i < kFrames; ++i) {
      const StampedPose& pose = truth[static_cast<std::size_t>(i)];
      frames.push_back(sim::render(scene, camera, pose.world_from_camera, pose.time));
      frames.back().index = i;
    }
  }
  Frame frame(int i) const { return frames[static_cast<std::size_t>(i)]; }
  const SE3& pose(int i) const { return truth[static_cast<std::size_t>(i)].world_from_camera; }
};

const Scan& scan() {
  static const Scan instance;
  return instance;
}

Frame with_readings(Frame frame, std::uint16_t reading) {
  std::fill(frame.depth.pixels.begin(), frame.depth.pixels.end(), reading);
  return frame;
}

class LostFrames : public testing::Test {
 protected:
  std::shared_ptr<Backend> backend_ = make_backend("cpu", 1);
};

bool same(const Mesh& a, const Mesh& b) {
  return a.positions.size() == b.positions.size() && a.triangles.size() == b.triangles.size() &&
         std::memcmp(a.positions.data(), b.positions.data(), a.positions.size() * sizeof(Mesh::Float3)) == 0 &&
         std::memcmp(a.triangles.data(), b.triangles.data(), a.triangles.size() * sizeof(Mesh::Triangle)) == 0;
}

double pose_error(const FrameReport& report) {
  return (report.world_from_camera.translation() - scan().pose(report.index).translation()).norm();
}

TEST_F(LostFrames, LeaveTheModelAndThePoseAndTrackingGoesOn) {
  // Black, a wall close to the lens, and readings beyond the range: three ways to see nothing that is known.
  Pipeline pipeline(small_parameters(), scan().camera, *backend_, scan().pose(0));
  for (int i = 0; i < 4; ++i) ASSERT_NE(pipeline.process(scan().frame(i)).tracking.status, TrackingStatus::lost);
  const SE3 accepted = pipeline.process(scan().frame(4)).world_from_camera;
  const Mesh before = pipeline.extract_mesh();
  ASSERT_GT(before.triangles.size(), 3000u);
  const Frame next = scan().frame(5);
  for (const std::uint16_t reading : std::initializer_list<std::uint16_t>{0, 2000, 65535}) {
    const FrameReport report = pipeline.process(with_readings(next, reading));
    EXPECT_EQ(report.tracking.status, TrackingStatus::lost) << reading;
    EXPECT_EQ(report.tracking.reason, reading == 2000 ? LostReason::few_inliers : LostReason::no_depth) << reading;
    EXPECT_EQ(report.world_from_camera.translation(), accepted.translation()) << "the previous accepted pose";
    EXPECT_EQ(report.world_from_camera.rotation(), accepted.rotation());
    EXPECT_EQ(report.milliseconds.integrate, 0) << "not fused";
    EXPECT_EQ(report.index, 5);
    EXPECT_EQ(report.time, next.time);
    EXPECT_TRUE(same(before, pipeline.extract_mesh()));
  }
  for (int i = 6; i < kFrames; ++i) {
    const FrameReport report = pipeline.process(scan().frame(i));
    ASSERT_EQ(report.tracking.status, TrackingStatus::tracked) << i;
    EXPECT_LT(pose_error(report), 5e-3);
  }
  EXPECT_FALSE(same(before, pipeline.extract_mesh())) << "fused again";
}

TEST_F(LostFrames, ALostFrameIsAsIfItHadNotBeen) {
  Pipeline disturbed(small_parameters(), scan().camera, *backend_, scan().pose(0));
  Pipeline quiet(small_parameters(), scan().camera, *backend_, scan().pose(0));
  for (int i = 0; i < 6; ++i) {
    const FrameReport expected = quiet.process(scan().frame(i));
    const FrameReport report = disturbed.process(scan().frame(i));
    disturbed.process(with_readings(scan().frame(i), 0));
    disturbed.process(with_readings(scan().frame(i), 2000));
    EXPECT_EQ(report.world_from_camera.translation(), expected.world_from_camera.translation()) << i;
    EXPECT_EQ(report.world_from_camera.rotation(), expected.world_from_camera.rotation()) << i;
  }
  EXPECT_TRUE(same(quiet.extract_mesh(), disturbed.extract_mesh()));
}

TEST_F(LostFrames, ReadingsOutOfRangeDoNotStartTheModel) {
  // Were the first frame taken for the model, an empty one, nothing could be tracked against it ever after.
  Pipeline pipeline(small_parameters(), scan().camera, *backend_, scan().pose(0));
  EXPECT_EQ(pipeline.process(with_readings(scan().frame(0), 65535)).tracking.reason, LostReason::no_depth);
  EXPECT_EQ(pipeline.process(scan().frame(0)).tracking.status, TrackingStatus::initialised);
  EXPECT_EQ(pipeline.process(scan().frame(1)).tracking.status, TrackingStatus::tracked);
}

TEST_F(LostFrames, PixelUseExplainsTheFrame) {
  Pipeline pipeline(small_parameters(), scan().camera, *backend_, scan().pose(0));
  pipeline.process(scan().frame(0));
  Frame frame = scan().frame(1);
  for (int v = 30; v < 50; ++v) std::fill(frame.depth.row(v) + 40, frame.depth.row(v) + 60, std::uint16_t{0});
  for (int v = 30; v < 50; ++v) std::fill(frame.depth.row(v) + 80, frame.depth.row(v) + 110, std::uint16_t{4000});
  FrameDiagnostics diagnostics;
  diagnostics.want_pixel_use = diagnostics.want_iterations = true;
  const FrameReport report = pipeline.process(frame, &diagnostics);
  const Image<std::uint8_t>& use = diagnostics.pixel_use;
  ASSERT_EQ(report.tracking.status, TrackingStatus::tracked);
  ASSERT_EQ(use.width, 160);
  ASSERT_EQ(use.height, 120);
  const auto is = [&](int u, int v, kernels::PixelUse code) { return use.at(u, v) == static_cast<std::uint8_t>(code); };
  for (int v = 30; v < 50; ++v) {
    for (int u = 40; u < 60; ++u) ASSERT_TRUE(is(u, v, kernels::PixelUse::no_depth)) << u << ", " << v;
  }
  int too_far = 0;
  for (int v = 30; v < 50; ++v) {
    for (int u = 80; u < 110; ++u) {
      ASSERT_FALSE(is(u, v, kernels::PixelUse::used)) << u << ", " << v;
      too_far += is(u, v, kernels::PixelUse::distance);
    }
  }
  EXPECT_GT(too_far, 400) << "of 600; the others meet an edge";
  const auto used = std::count(use.pixels.begin(), use.pixels.end(), std::uint8_t{0});
  EXPECT_NEAR(static_cast<double>(used), report.tracking.inliers, 0.02 * report.tracking.inliers)
      << "the report counts before the last step, the image after it";
  ASSERT_FALSE(diagnostics.iterations.empty());
  EXPECT_EQ(diagnostics.iterations.back().matched, report.tracking.inliers);

  FrameDiagnostics of_empty, of_lost;
  of_empty.want_pixel_use = of_lost.want_pixel_use = of_empty.want_iterations = true;
  pipeline.process(with_readings(scan().frame(2), 0), &of_empty);
  EXPECT_TRUE(of_empty.pixel_use.empty() && of_empty.iterations.empty()) << "it was not registered";
  pipeline.process(with_readings(scan().frame(2), 2000), &of_lost);
  ASSERT_EQ(of_lost.pixel_use.width, 160) << "it was, in vain";
  EXPECT_TRUE(of_lost.iterations.empty()) << "nobody asked";
  EXPECT_EQ(std::count(of_lost.pixel_use.pixels.begin(), of_lost.pixel_use.pixels.end(), std::uint8_t{0}), 0);
}

TEST_F(LostFrames, AskingForDiagnosticsChangesNothing) {
  Pipeline asked(small_parameters(), scan().camera, *backend_, scan().pose(0));
  Pipeline quiet(small_parameters(), scan().camera, *backend_, scan().pose(0));
  for (int i = 0; i < 4; ++i) {
    FrameDiagnostics diagnostics;
    diagnostics.want_pixel_use = diagnostics.want_iterations = true;
    EXPECT_EQ(asked.process(scan().frame(i), &diagnostics).world_from_camera.translation(),
              quiet.process(scan().frame(i)).world_from_camera.translation());
  }
}

TEST_F(LostFrames, ContradictingParametersAreAnError) {
  Parameters parameters = small_parameters();
  parameters.preprocess.min_depth = 9;
  EXPECT_THROW(Pipeline(parameters, scan().camera, *backend_), Error);
}

}  // namespace
}  // namespace plumbline
