// The whole pipeline on an analytic scene, whose camera path and surface are known exactly.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstring>

#include "pipeline/runs.h"
#include "plumbline/error.h"
#include "plumbline/evaluation.h"
#include "plumbline/frame.h"
#include "plumbline/image.h"
#include "plumbline/mesh.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "plumbline/statistics.h"
#include "plumbline/trajectory.h"
#include "sim/analytic_scene.h"

namespace plumbline {
namespace {

#if defined(__SANITIZE_ADDRESS__)
constexpr int kFrames = 8;  // a frame takes seconds there
#else
constexpr int kFrames = 40;
#endif

Pinhole small_camera() { return {262.5f, 262.5f, 159.5f, 119.5f, 320, 240}; }

Parameters small_parameters() {
  Parameters parameters = preset("kinectfusion");
  parameters.volume.resolution = 256;
  parameters.volume.side = 3.5;
  return parameters;
}

/// The desk corner rendered along the default orbit, once for all tests.
struct Scan {
  sim::AnalyticScene scene = sim::desk_corner();
  Trajectory truth = sim::orbit();
  std::vector<Frame> frames;

  Scan() {
    for (int i = 0; i < kFrames; ++i) {
      const StampedPose& pose = truth[static_cast<std::size_t>(i)];
      frames.push_back(sim::render(scene, small_camera(), pose.world_from_camera, pose.time));
      frames.back().index = i;
    }
    truth.resize(kFrames);
  }
};

const Scan& scan() {
  static const Scan instance;
  return instance;
}

test::Run run(const Parameters& parameters, int threads = 0, bool with_color = false) {
  return test::run_pipeline(
      parameters, small_camera(), kFrames, [](int i) { return scan().frames[static_cast<std::size_t>(i)]; }, threads,
      scan().truth.front().world_from_camera, with_color);
}

TEST(AnalyticPipeline, TracksEveryFrameAndFindsTheSurface) {
  const test::Run result = run(small_parameters());
  ASSERT_EQ(result.lost, 0);
  EXPECT_LT(eval::absolute_trajectory_error(scan().truth, result.trajectory).translation.rmse, 0.003);
  // Not even aligned: the world is that of the initial pose.
  const SE3 last_error = scan().truth.back().world_from_camera.inverse() * result.trajectory.back().world_from_camera;
  EXPECT_LT(last_error.translation().norm(), 0.008);
  EXPECT_LT(so3::angle(last_error.rotation()), 0.3 * 3.14159 / 180);

  ASSERT_GT(result.mesh.triangles.size(), 10000u);
  std::vector<double> distances;
  for (const Mesh::Float3& p : result.mesh.positions) distances.push_back(scan().scene.distance({p.x, p.y, p.z}));
  const eval::Statistics error = eval::statistics(distances);
  EXPECT_LT(error.mean, 0.004) << "voxels are 13.7 mm";
  EXPECT_LT(error.median, 0.003);
}

TEST(AnalyticPipeline, SameBitsForAnyNumberOfThreads) {
  const tbb::global_control more_than_cores(tbb::global_control::max_allowed_parallelism, 7);
  const test::Run one = run(small_parameters(), 1);
  for (const int threads : {2, 7}) {
    const test::Run other = run(small_parameters(), threads);
    ASSERT_EQ(one.trajectory.size(), other.trajectory.size());
    for (std::size_t i = 0; i < one.trajectory.size(); ++i) {
      EXPECT_EQ(one.trajectory[i].world_from_camera.rotation(), other.trajectory[i].world_from_camera.rotation());
      EXPECT_EQ(one.trajectory[i].world_from_camera.translation(), other.trajectory[i].world_from_camera.translation());
    }
    ASSERT_EQ(one.mesh.positions.size(), other.mesh.positions.size());
    EXPECT_EQ(std::memcmp(one.mesh.positions.data(), other.mesh.positions.data(),
                          one.mesh.positions.size() * sizeof(Mesh::Float3)),
              0);
    ASSERT_EQ(one.mesh.triangles.size(), other.mesh.triangles.size());
    EXPECT_EQ(std::memcmp(one.mesh.triangles.data(), other.mesh.triangles.data(),
                          one.mesh.triangles.size() * sizeof(Mesh::Triangle)),
              0);
  }
}

TEST(AnalyticPipeline, ColoursTheMesh) {
  const test::Run result = run(small_parameters(), 0, true);
  ASSERT_EQ(result.mesh.colors.size(), result.mesh.positions.size());
  // Compared with the pattern at the vertex's own place, away from the pattern's edges: most vertices must agree.
  int close = 0, checked = 0;
  for (std::size_t i = 0; i < result.mesh.positions.size(); i += 7) {
    const Mesh::Float3 &p = result.mesh.positions[i], &n = result.mesh.normals[i];
    const Eigen::Vector3d normal(n.x, n.y, n.z);
    const auto hit = scan().scene.intersect(Eigen::Vector3d(p.x, p.y, p.z) + 0.05 * normal, -normal);
    if (!hit || hit->t > 0.06) continue;
    ++checked;
    const Mesh::Rgb c = result.mesh.colors[i];
    close += std::abs(c.r - hit->color.r) + std::abs(c.g - hit->color.g) + std::abs(c.b - hit->color.b) < 60;
  }
  ASSERT_GT(checked, 500);
  EXPECT_GT(static_cast<double>(close) / checked, 0.8);
}

TEST(AnalyticPipeline, ABlackFrameIsLostAndTheModelIsKept) {
  const auto backend = make_backend("cpu");
  Pipeline pipeline(small_parameters(), small_camera(), *backend, scan().truth.front().world_from_camera);
  for (int i = 0; i < 5; ++i) pipeline.process(scan().frames[static_cast<std::size_t>(i)]);
  const Mesh before = pipeline.extract_mesh();

  Frame black = scan().frames[5];
  std::fill(black.depth.pixels.begin(), black.depth.pixels.end(), std::uint16_t{0});
  const FrameReport lost = pipeline.process(black);
  EXPECT_EQ(lost.tracking.status, TrackingStatus::lost);
  EXPECT_EQ(lost.tracking.reason, LostReason::no_depth);
  const Mesh after = pipeline.extract_mesh();
  ASSERT_EQ(before.positions.size(), after.positions.size());
  EXPECT_EQ(
      std::memcmp(before.positions.data(), after.positions.data(), before.positions.size() * sizeof(Mesh::Float3)), 0);
  EXPECT_EQ(pipeline.process(scan().frames[6]).tracking.status, TrackingStatus::tracked);
}

TEST(AnalyticPipeline, BlackFramesBeforeTheFirstReadingDoNotStartTheModel) {
  const auto backend = make_backend("cpu");
  Pipeline pipeline(small_parameters(), small_camera(), *backend);
  Frame black = scan().frames[0];
  std::fill(black.depth.pixels.begin(), black.depth.pixels.end(), std::uint16_t{0});
  EXPECT_EQ(pipeline.process(black).tracking.reason, LostReason::no_depth);
  EXPECT_EQ(pipeline.process(scan().frames[0]).tracking.status, TrackingStatus::initialised);
  EXPECT_EQ(pipeline.process(scan().frames[1]).tracking.status, TrackingStatus::tracked);
}

TEST(AnalyticPipeline, ASceneBeyondTheVolumeIsLostNotWrong) {
  Parameters parameters = small_parameters();
  parameters.volume.side = 0.5;  // the desk is 2 m away
  const test::Run result = run(parameters);
  EXPECT_EQ(result.lost, kFrames - 1);
  EXPECT_EQ(result.reports[1].tracking.reason, LostReason::few_inliers);
  EXPECT_TRUE(result.mesh.triangles.empty());
}

TEST(AnalyticPipeline, TheCameraMayStandInsideTheVolume) {
  // OpenCV's KinFu shifts the surface when it does; here the error must stay that of a camera outside.
  Parameters parameters = small_parameters();
  parameters.volume.side = 4.5;
  parameters.volume.offset = -0.4;
  const test::Run result = run(parameters);
  EXPECT_EQ(result.lost, 0);
  double sum = 0;
  for (const Mesh::Float3& p : result.mesh.positions) sum += scan().scene.distance({p.x, p.y, p.z});
  EXPECT_LT(sum / static_cast<double>(result.mesh.positions.size()), 0.005) << "voxels are 17.6 mm";
}

TEST(AnalyticPipeline, AFittedVolumeHoldsTheScene) {
  Parameters parameters = small_parameters();
  parameters.volume.placement = VolumePlacement::fit;
  parameters.volume.side = 10;  // the most that a fit may take
  parameters.volume.truncation = 0.05;
  const auto backend = make_backend("cpu");
  Pipeline pipeline(parameters, small_camera(), *backend);
  for (int i = 0; i < std::min(10, kFrames); ++i)
    EXPECT_NE(pipeline.process(scan().frames[static_cast<std::size_t>(i)]).tracking.status, TrackingStatus::lost);
  EXPECT_LT(pipeline.volume_side(), 6.0);
  EXPECT_GT(pipeline.volume_side(), 1.5);
  EXPECT_GT(pipeline.extract_mesh().triangles.size(), 10000u);
}

TEST(AnalyticPipeline, AVolumeMayBeGivenByItsPose) {
  // Turned by 30° about the vertical and placed around the desk by hand: the surface must not depend on it.
  const SE3 world_from_volume(Eigen::Quaterniond(Eigen::AngleAxisd(0.5236, Eigen::Vector3d::UnitZ())),
                              {-0.3, -2.4, -0.4});
  const Eigen::Quaterniond q = world_from_volume.quaternion();
  Parameters parameters = small_parameters();
  parameters.volume.placement = VolumePlacement::given;
  parameters.volume.pose = {-0.3, -2.4, -0.4, q.x(), q.y(), q.z(), q.w()};
  const test::Run result = run(parameters);
  EXPECT_EQ(result.lost, 0);
  ASSERT_GT(result.mesh.positions.size(), 5000u);
  double sum = 0;
  for (const Mesh::Float3& p : result.mesh.positions) {
    sum += scan().scene.distance({p.x, p.y, p.z});
    const Eigen::Vector3d local = world_from_volume.inverse() * Eigen::Vector3d(p.x, p.y, p.z);
    EXPECT_TRUE((local.array() > -1e-3).all() && (local.array() < 3.501).all());
  }
  EXPECT_LT(sum / static_cast<double>(result.mesh.positions.size()), 0.004);
}

TEST(AnalyticPipeline, TheVolumeFollowsTheCamera) {
  // Past boxes and balls for 5 m, in a volume of 2.4 m; one that stays loses the camera.
  sim::AnalyticScene scene{{sim::plane({0, 0, -0.8}, {0, 0, 1}), sim::plane({0, 1.0, 0}, {0, -1, 0})}};
  for (int i = 0; i < 12; ++i) {
    const double x = -0.6 + 0.6 * i;
    scene.primitives.push_back(sim::sphere({x, 0.8, 0.1 * (i % 3) - 0.4}, 0.25));
    scene.primitives.push_back(sim::box(SE3(Eigen::Matrix3d::Identity(), {x + 0.3, 0.6, -0.7}), {0.1, 0.15, 0.2}));
  }
  constexpr int kCount = 126;
  const auto pose = [](int i) {
    const double x = 0.04 * i;
    return sim::look_at({x, -0.4, 0.1}, {x + 0.3, 0.8, -0.5});
  };
  const auto frame = [&](int i) {
    Frame f = sim::render(scene, small_camera(), pose(i), Nanoseconds{33'333'333} * i);
    f.index = i;
    return f;
  };
  Parameters parameters = small_parameters();
  parameters.volume.side = 2.4;
  parameters.volume.resolution = 96;
  parameters.volume.offset = -0.3;
  parameters.volume.placement = VolumePlacement::follow;
  const test::Run run = test::run_pipeline(parameters, small_camera(), kCount, frame, 0, pose(0));
  EXPECT_EQ(run.lost, 0);
  const SE3 error = pose(kCount - 1).inverse() * run.trajectory.back().world_from_camera;
  EXPECT_LT(error.translation().norm(), 0.05) << "of 5 m";
  double lowest = 1e9, highest = -1e9;
  for (const Mesh::Float3& p : run.mesh.positions) {
    lowest = std::min(lowest, double{p.x});
    highest = std::max(highest, double{p.x});
  }
  EXPECT_GT(highest - lowest, 5.5) << "what it left is in the mesh";

  parameters.volume.placement = VolumePlacement::front;
  EXPECT_GT(test::run_pipeline(parameters, small_camera(), kCount, frame, 0, pose(0)).lost, 30);
}

TEST(AnalyticPipeline, TheMeshFacesTheFreeSide) {
  const test::Run result = run(small_parameters());
  std::size_t agree = 0;
  const auto at = [](const Mesh::Float3& p) { return Eigen::Vector3f(p.x, p.y, p.z); };
  for (const Mesh::Triangle& t : result.mesh.triangles) {
    const Eigen::Vector3f a = at(result.mesh.positions[t.a]), b = at(result.mesh.positions[t.b]),
                          c = at(result.mesh.positions[t.c]);
    agree += (b - a).cross(c - a).dot(at(result.mesh.normals[t.a])) > 0;
  }
  EXPECT_GT(static_cast<double>(agree), 0.99 * static_cast<double>(result.mesh.triangles.size()));
}

TEST(AnalyticPipeline, ExplainsItsPixels) {
  const auto backend = make_backend("cpu");
  Pipeline pipeline(small_parameters(), small_camera(), *backend);
  FrameDiagnostics diagnostics;
  diagnostics.want_pixel_use = true;
  const Image<std::uint8_t>& use = diagnostics.pixel_use;
  pipeline.process(scan().frames[0], &diagnostics);
  EXPECT_TRUE(use.empty()) << "the first frame is not registered";
  const FrameReport report = pipeline.process(scan().frames[1], &diagnostics);
  ASSERT_EQ(use.width, 320);
  int used = 0;
  for (const std::uint8_t code : use.pixels) used += code == static_cast<std::uint8_t>(kernels::PixelUse::used);
  // At the final estimate, one iteration after the reported count.
  EXPECT_NEAR(used, report.tracking.inliers, 0.02 * report.tracking.inliers);
}

TEST(AnalyticPipeline, AFrameOfAnotherSizeIsAnError) {
  const auto backend = make_backend("cpu");
  Pipeline pipeline(small_parameters(), small_camera(), *backend);
  Frame frame = scan().frames[0];
  frame.depth = DepthImage(160, 120);
  EXPECT_THROW(pipeline.process(frame), Error);
}

}  // namespace
}  // namespace plumbline
