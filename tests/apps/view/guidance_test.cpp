// What whoever holds the camera is told, by made-up reports.
#include "view/guidance.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

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
  void see(double sharpness) { guide_.observe_sharpness(sharpness); }
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

/// Two seconds of images that are sharp, then some that are not.
std::string after_blur(double degrees_a_second, double sharp, double blurred, int images) {
  Walk walk;
  std::string hint;
  for (int i = 0; i < 60 + images; ++i) {
    walk.see(i < 60 ? sharp : blurred);
    hint = walk.next(degrees_a_second, 0.0);
  }
  return hint;
}

TEST(Guide, SaysSlowerOfBlur) {
  EXPECT_EQ(after_blur(30, 0.5, 0.25, 3), "slower");
  EXPECT_EQ(after_blur(30, 0.2, 0.1, 5), "slower") << "what counts is how sharp the images of this place are";
  EXPECT_EQ(after_blur(30, 0.5, 0.45, 5), "") << "they are never all the same";
  EXPECT_EQ(after_blur(30, 0.5, 0.25, 1), "") << "one image says nothing";
  EXPECT_EQ(after_blur(2, 0.5, 0.25, 5), "") << "it is not the motion";
}

/// A pattern of blocks, moved over so many pixels a row while the shutter is open.
ColorImage smeared(int pixels) {
  ColorImage image(120, 80, 3);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      int sum = 0;
      for (int k = 0; k < pixels; ++k) sum += ((x + k) / 7 * 31 + y / 7 * 57) % 5 * 50;
      for (int c = 0; c < 3; ++c) image.row(y)[3 * x + c] = static_cast<std::uint8_t>(sum / pixels);
    }
  return image;
}

TEST(Sharpness, FallsWithMotion) {
  const double sharp = sharpness(smeared(1)), little = sharpness(smeared(3)), much = sharpness(smeared(8));
  EXPECT_GT(sharp, 1.2 * little);
  EXPECT_GT(little, 1.2 * much);
  EXPECT_EQ(sharpness(ColorImage(120, 80, 3)), 0);
}

TEST(Guide, SaysWhatStandsInTheWay) {
  EXPECT_TRUE(standing_hints(5'000'000'000, "out", "calibrated").empty());
  EXPECT_TRUE(standing_hints(std::nullopt, "out", "").empty());
  const std::vector<Hint> both = standing_hints(300'000'000, "out", "not calibrated");
  ASSERT_EQ(both.size(), 2U);
  EXPECT_EQ(both[0].kind, "disk");
  EXPECT_EQ(both[0].detail, "300 MB are left at out.");
  EXPECT_EQ(both[1].kind, "sensor");
  EXPECT_EQ(both[1].text, "Turn the sensor around");
  EXPECT_EQ(standing_hints(std::nullopt, "out", "not connected").front().text, "The sensor is silent");
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
