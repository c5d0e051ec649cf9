#include "eval/time_offset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>

#include "plumbline/error.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"

namespace plumbline::eval {
namespace {

using ::testing::HasSubstr;

/// A winding path, from `begin` to `end` seconds, `rate` poses a second.
Trajectory winding(double begin, double end, double rate) {
  Trajectory trajectory;
  for (double s = begin; s < end; s += 1 / rate) {
    const Eigen::Vector3d position(std::sin(0.7 * s), 0.5 * std::cos(1.9 * s), 0.3 * std::sin(3.1 * s));
    trajectory.push_back({from_seconds(1e9 + s), SE3(so3::exp({0.1, 0.2 * s, 0}), position)});
  }
  return trajectory;
}

Trajectory later(Trajectory trajectory, double seconds) {
  for (StampedPose& pose : trajectory) pose.time += from_seconds(seconds);
  return trajectory;
}

std::string message_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(TimeOffset, FindsWhatTheClocksDifferBy) {
  const Trajectory reference = winding(0, 20, 100), exact = winding(1, 19, 30);
  const SE3 moved(so3::exp({1, 2, 0.5}), {3, -4, 5});
  for (const double late : {0.0373, -0.1012, 0.0}) {
    Trajectory estimate = later(exact, late);
    std::mt19937_64 random(4);
    std::normal_distribution<double> noise(0, 0.002);
    for (StampedPose& pose : estimate) {
      const Eigen::Vector3d shift(noise(random), noise(random), noise(random));
      pose.world_from_camera =
          moved * SE3(pose.world_from_camera.rotation(), pose.world_from_camera.translation() + shift);
    }
    const TimeOffset found = best_time_offset(reference, estimate);
    EXPECT_NEAR(to_seconds(found.best), -late, 3e-4);
    EXPECT_NEAR(found.rmse, 0.002 * std::sqrt(3.0), 2e-4);
    EXPECT_FALSE(found.at_the_border);
    EXPECT_GT(found.poses, 500u);
    if (late != 0) {
      EXPECT_GT(found.rmse_as_given, 5 * found.rmse);
    }
    // What was applied already is part of the answer.
    const TimeOffset again = best_time_offset(reference, estimate, {.offset = from_seconds(-late + 0.05)});
    EXPECT_NEAR(to_seconds(again.best), -late, 3e-4);
  }
}

TEST(TimeOffset, SaysThatTheBestLiesAtTheBorder) {
  const Trajectory reference = winding(0, 20, 100);
  const TimeOffset found = best_time_offset(reference, later(winding(2, 18, 30), 0.3));
  EXPECT_TRUE(found.at_the_border);
  const TimeOffset wide = best_time_offset(reference, later(winding(2, 18, 30), 0.3), {.range = kNanosecondsPerSecond});
  EXPECT_FALSE(wide.at_the_border);
  EXPECT_NEAR(to_seconds(wide.best), -0.3, 1e-4);
}

TEST(TimeOffset, PosesInAHoleOfTheReferenceDoNotCount) {
  Trajectory reference;
  for (const StampedPose& pose : winding(0, 20, 100))
    if (const double s = to_seconds(pose.time) - 1e9; s < 8 || s > 12) reference.push_back(pose);
  const TimeOffset found = best_time_offset(reference, later(winding(1, 19, 30), 0.05));
  EXPECT_NEAR(to_seconds(found.best), -0.05, 1e-4);
  EXPECT_LT(found.rmse, 1e-4);
  // 18 s of poses, less the hole of 4 s and 0.2 s on both sides of it.
  EXPECT_NEAR(static_cast<double>(found.poses), 30 * (18 - 4.4), 4);
}

TEST(TimeOffset, RefusesWhatItCannotCompare) {
  const Trajectory reference = winding(0, 2, 100);
  EXPECT_THAT(message_of([&] { best_time_offset(reference, winding(50, 60, 30)); }), HasSubstr("only 0 poses"));
  EXPECT_THAT(message_of([&] { best_time_offset({}, reference); }), HasSubstr("only 0 poses"));
  EXPECT_THAT(message_of([&] { best_time_offset(reference, reference, {.range = 0}); }), HasSubstr("not positive"));
  Trajectory backwards = reference;
  std::swap(backwards[3], backwards[50]);
  EXPECT_THAT(message_of([&] { best_time_offset(reference, backwards); }), HasSubstr("order of time"));
}

}  // namespace
}  // namespace plumbline::eval
