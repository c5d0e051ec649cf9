// A path that drifted while the camera turned about in a room is corrected where it sees the same again; one that did
// not drift stays as it is; a room that looks the same is no loop.
#include "graph/close_loops.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "graph/loops.h"
#include "plumbline/angles.h"
#include "plumbline/backend.h"
#include "sim/analytic_scene.h"
#include "sim/depth_camera.h"
#include "sim/scenes.h"

namespace plumbline {
namespace {

const Pinhole kCamera = {262.5f, 262.5f, 159.5f, 119.5f, 320, 240};

/// What a simulated camera sees from poses.
class Seen : public Sequence {
 public:
  Seen(const Mesh& scene, std::vector<SE3> poses)
      : Sequence(info(), times(poses.size())), camera_(scene, options()), poses_(std::move(poses)) {}
  Frame read(int index) const override {
    Frame frame = camera_.capture(poses_.at(static_cast<std::size_t>(index)), index);
    frame.index = index;
    frame.time = time(index);
    return frame;
  }
  ImuRecording read_imu(std::vector<std::string>*) const override { return {}; }

 private:
  static SequenceInfo info() {
    SequenceInfo info;
    info.camera = kCamera;
    info.depth_scale = 5000;
    return info;
  }
  static std::vector<Nanoseconds> times(std::size_t count) {
    std::vector<Nanoseconds> list;
    for (std::size_t i = 0; i < count; ++i) list.push_back(static_cast<Nanoseconds>(i) * kNanosecondsPerSecond / 10);
    return list;
  }
  static sim::DepthCameraOptions options() {
    sim::DepthCameraOptions options;
    options.camera = kCamera;
    options.color = false;
    options.model.distortion = 0;
    return options;
  }

  sim::DepthCamera camera_;
  std::vector<SE3> poses_;
};

/// One and a quarter turns on the spot, nearly: about a circle of half a metre.
std::vector<SE3> turning_about(const Eigen::Vector3d& centre) {
  std::vector<SE3> poses;
  constexpr int kFrames = 100;
  for (int i = 0; i < kFrames; ++i) {
    const double angle = 2.5 * std::numbers::pi * i / kFrames;
    const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0);
    poses.push_back(
        sim::look_at(centre + 0.25 * out, centre + 2 * out - Eigen::Vector3d(0, 0, 0.6), Eigen::Vector3d::UnitZ()));
  }
  return poses;
}

/// The poses as a tracker has them that errs a little with every frame; the camera's first pose is the world.
std::vector<PathFrame> drifting(const std::vector<SE3>& poses, double metres, double radians) {
  std::vector<PathFrame> path;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(poses.size());
    const SE3 pose = poses.front().inverse() * poses[i];
    path.push_back({static_cast<int>(i), SE3(so3::exp(Eigen::Vector3d(0.3, 1, 0.2) * radians * share) * pose.rotation(),
                                             pose.translation() + metres * share * Eigen::Vector3d(1, 0.2, 0.5))});
  }
  return path;
}

/// Metres and radians by which the final pose errs against the first.
Vector6d end_error(const std::vector<SE3>& truth, const SE3& first, const SE3& final) {
  return pose_difference(first.inverse() * final, truth.front().inverse() * truth.back());
}

class CloseLoops : public testing::Test {
 protected:
  const std::vector<SE3> truth_ = turning_about({0.2, 0, 1.3});
  const Seen room_{sim::make_scene("room").mesh, truth_};
  ClosedLoops close(const std::vector<PathFrame>& path, int threads,
                    GlobalCorrection correction = GlobalCorrection::automatic) const {
    return close_loops(room_, path, Parameters(), *make_backend("cpu", threads), {correction});
  }
};

TEST_F(CloseLoops, CorrectsADriftWithTheSameBitsForAnyNumberOfThreads) {
  const std::vector<PathFrame> path = drifting(truth_, 0.12, radians(4));
  const ClosedLoops one = close(path, 1), four = close(path, 4);
  ASSERT_TRUE(one.report.is_applied) << one.report.note;
  EXPECT_GE(one.report.accepted(), 3);
  EXPECT_LT(one.report.disagreement_after, 0.5 * one.report.disagreement_before);
  ASSERT_EQ(one.world_from_camera.size(), path.size());
  const Vector6d before = end_error(truth_, path.front().world_from_camera, path.back().world_from_camera),
                 after = end_error(truth_, one.world_from_camera.front(), one.world_from_camera.back());
  EXPECT_LT(after.head<3>().norm(), 0.25 * before.head<3>().norm());
  EXPECT_LT(after.tail<3>().norm(), 0.25 * before.tail<3>().norm());
  EXPECT_NEAR(one.report.max_translation, before.tail<3>().norm(), 0.05);
  for (std::size_t i = 0; i < path.size(); ++i) {
    EXPECT_EQ(one.world_from_camera[i].translation(), four.world_from_camera[i].translation());
    EXPECT_EQ(one.world_from_camera[i].rotation(), four.world_from_camera[i].rotation());
  }
}

TEST_F(CloseLoops, LeavesAPathThatDidNotDrift) {
  const ClosedLoops closed = close(drifting(truth_, 0, 0), 2);
  EXPECT_GE(closed.report.accepted(), 3);
  EXPECT_FALSE(closed.report.is_applied);
  EXPECT_TRUE(closed.world_from_camera.empty());
  EXPECT_FALSE(closed.report.note.empty());
}

TEST_F(CloseLoops, LoopsAreRightAndRefusalsHaveReasons) {
  const std::vector<PathFrame> path = drifting(truth_, 0.12, radians(4));
  const ClosedLoops closed = close(path, 2, GlobalCorrection::on);
  int refused = 0;
  for (const LoopReport& loop : closed.report.loops) {
    refused += loop.status != LoopStatus::accepted;
    if (loop.status != LoopStatus::accepted) continue;
    // What the loop says the path is wrong by is what it is wrong by.
    const auto first = static_cast<std::size_t>(loop.first_frame), second = static_cast<std::size_t>(loop.second_frame);
    const SE3 tracked = path[first].world_from_camera.inverse() * path[second].world_from_camera;
    const Vector6d wrong = pose_difference(tracked, truth_[first].inverse() * truth_[second]);
    EXPECT_NEAR(loop.rotation, wrong.head<3>().norm(), radians(1));
    EXPECT_NEAR(loop.translation, wrong.tail<3>().norm(), 0.03);
  }
  EXPECT_EQ(refused + closed.report.accepted(), static_cast<int>(closed.report.loops.size()));
}

// Only pairs of views whose poses happen to be near are registered at first: what they say brings the others near.
TEST_F(CloseLoops, LooksAgainWhereTheFirstLoopsPutTheViews) {
  const std::vector<PathFrame> path = drifting(truth_, 0.35, radians(8));
  const ClosedLoops closed = close(path, 2);
  ASSERT_TRUE(closed.report.is_applied) << closed.report.note;
  EXPECT_GE(closed.report.accepted(), 6);
  const Vector6d before = end_error(truth_, path.front().world_from_camera, path.back().world_from_camera),
                 after = end_error(truth_, closed.world_from_camera.front(), closed.world_from_camera.back());
  EXPECT_LT(after.head<3>().norm(), 0.1 * before.head<3>().norm());
  EXPECT_LT(after.tail<3>().norm(), 0.1 * before.tail<3>().norm());
}

TEST_F(CloseLoops, EndsWhenItIsToStop) {
  const ClosedLoops closed = close_loops(room_, drifting(truth_, 0.12, radians(4)), Parameters(),
                                         *make_backend("cpu", 1), {GlobalCorrection::on, [] { return true; }});
  EXPECT_TRUE(closed.world_from_camera.empty());
  EXPECT_EQ(closed.report.note, "interrupted");
}

TEST(LookAlikes, AreRefusedByThePath) {
  // The rooms at one side of this corridor are furnished alike, 6.6 m apart.
  std::vector<SE3> poses = turning_about({0, 4.4, 1.3});
  const std::vector<SE3> next_door = turning_about({6.6, 4.4, 1.3});
  poses.insert(poses.end(), next_door.begin(), next_door.end());
  const Seen twins(sim::make_scene("twins").mesh, poses);
  std::vector<PathFrame> path = drifting(poses, 0, 0);
  const std::shared_ptr<Backend> backend = make_backend("cpu", 2);
  const Parameters parameters;
  std::vector<std::size_t> chosen = {0, 5, 10, 100, 105, 110};
  std::vector<PathView> views = read_views(twins, path, chosen, parameters, *backend, {});
  ASSERT_EQ(views.size(), chosen.size());
  ViewMatcher matcher(parameters, kCamera, *backend);
  std::vector<std::optional<ViewEdge>> neighbours;
  for (std::size_t i = 0; i + 1 < views.size(); ++i) neighbours.push_back(matcher.match(views, i, i + 1, Reach::near));
  const Odometry odometry(views, neighbours, 1);

  std::vector<PathView> deceived = views;
  for (std::size_t i = 0; i < 3; ++i) deceived[i + 3].world_from_camera = views[i].world_from_camera;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::optional<ViewEdge> edge = matcher.match(deceived, i, i + 3, Reach::far);
    ASSERT_TRUE(edge);
    EXPECT_EQ(judge_alone(*edge, 1), LoopStatus::accepted) << "the views tell no difference";
    EXPECT_EQ(judge(*edge, odometry, 1), LoopStatus::too_far);
  }
  EXPECT_TRUE(loop_candidates(views).empty());
}

}  // namespace
}  // namespace plumbline
