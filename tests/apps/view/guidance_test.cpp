// What whoever holds the camera is told, by made-up reports.
#include "view/guidance.h"

#include <gtest/gtest.h>

#include <string>

#include "plumbline/angles.h"

namespace plumbline::app {
namespace {

/// A camera that turns and moves steadily.
class Walk {
 public:
  std::string next(double degrees_a_second, double metres_a_second, const DepthStatistics& depth = {0.8, 1.5},
                   const TrackingResult& tracking = good()) {
    ++frame_;
    FrameReport report;
    report.index = frame_;
    report.time = from_seconds(frame_ / 30.0);
    report.tracking = tracking;
    const double angle = degrees_a_second * frame_ / 30.0 / kDegreesPerRadian;
    report.world_from_camera = SE3(Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY())),
                                   {metres_a_second * frame_ / 30.0, 0, 0});
    const std::vector<Hint> hints = guide_.advise(report, depth);
    return hints.empty() ? "" : hints.front().kind;
  }
  static TrackingResult good() {
    TrackingResult tracking;
    tracking.status = TrackingStatus::tracked;
    tracking.iterations = {4, 5, 10};
    tracking.inlier_fraction = 0.8;
    tracking.rank = 6;
    tracking.condition = 50;
    return tracking;
  }

 private:
  Guide guide_{8};
  int frame_ = 0;
};

/// After a second of it.
template <class... Args>
std::string after_a_second(const Args&... args) {
  Walk walk;
  std::string hint;
  for (int i = 0; i < 30; ++i) hint = walk.next(args...);
  return hint;
}

TEST(Guide, IsSilentWhenAllIsWell) { EXPECT_EQ(after_a_second(20.0, 0.3), ""); }

TEST(Guide, SaysSlowerOfTurnsAndMoves) {
  EXPECT_EQ(after_a_second(70.0, 0.0), "slower");
  EXPECT_EQ(after_a_second(-70.0, 0.0), "slower");
  EXPECT_EQ(after_a_second(0.0, 1.5), "slower");
  EXPECT_EQ(after_a_second(0.0, 1.5, DepthStatistics{0.8, 4.0}), "") << "what is far may pass faster";
}

TEST(Guide, SaysCloserAndFarther) {
  EXPECT_EQ(after_a_second(5.0, 0.0, DepthStatistics{0.8, 6.5}), "closer");
  EXPECT_EQ(after_a_second(5.0, 0.0, DepthStatistics{0.2, 3.0}), "closer");
  EXPECT_EQ(after_a_second(5.0, 0.0, DepthStatistics{0.8, 0.4}), "farther");
  EXPECT_EQ(after_a_second(5.0, 0.0, DepthStatistics{0.2, 0.7}), "farther");
}

TEST(Guide, SaysWhenThereIsTooLittleToHoldOnTo) {
  TrackingResult wall = Walk::good();
  wall.condition = 1e5;
  EXPECT_EQ(after_a_second(5.0, 0.0, DepthStatistics{0.8, 1.5}, wall), "little");
  wall = Walk::good();
  wall.rank = 5;
  EXPECT_EQ(after_a_second(5.0, 0.0, DepthStatistics{0.8, 1.5}, wall), "little");
  Walk walk;
  for (int i = 0; i < 30; ++i) walk.next(5, 0);
  EXPECT_EQ(walk.next(5, 0, {0.8, 1.5}, wall), "") << "one frame says nothing";
}

TEST(Guide, SaysTurnBackWhenLost) {
  TrackingResult lost = Walk::good();
  lost.status = TrackingStatus::lost;
  lost.reason = LostReason::few_inliers;
  Walk walk;
  for (int i = 0; i < 10; ++i) walk.next(70, 0);
  EXPECT_EQ(walk.next(70, 0, {0.8, 1.5}, lost), "back") << "before everything else";
  lost.status = TrackingStatus::provisional;
  EXPECT_EQ(walk.next(70, 0, {0.8, 1.5}, lost), "confirm");
  EXPECT_EQ(walk.next(70, 0), "") << "the turn while it was lost does not count";
}

}  // namespace
}  // namespace plumbline::app
