// The program's parts that need no process.
#include <gtest/gtest.h>

#include "cli/arguments.h"
#include "cli/console.h"
#include "cli/progress.h"
#include "plumbline/error.h"
#include "plumbline/se3.h"
#include "plumbline/trajectory.h"
#include "run/summary.h"

namespace plumbline::app {
namespace {

TEST(Numbers, TakeCommasAndBlanks) {
  EXPECT_EQ(parse_numbers("1,-2.5, 3e2\t+4", 4, "--x", "a,b,c,d"), (std::vector<double>{1, -2.5, 300, 4}));
}

TEST(Numbers, RefuseOthers) {
  for (const char* text : {"", "1", "1,2,3", "1,x", "1,2x", "nan,1", "1,inf", "1;2"})
    EXPECT_THROW(parse_numbers(text, 2, "--x", "a,b"), UsageError) << text;
}

TEST(Pose, IsTranslationThenQuaternionWithWLast) {
  const SE3 pose = parse_pose("1 2 3 0 0 0 1", "--pose");
  EXPECT_EQ(pose.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(pose.rotation(), Eigen::Matrix3d(Eigen::Matrix3d::Identity()));
  EXPECT_THROW(parse_pose("0 0 0 1 1 1 1", "--pose"), UsageError);
}

TEST(Size, IsWidthByHeight) {
  EXPECT_EQ(parse_size("640x480", "--size"), (std::pair{640, 480}));
  for (const char* text : {"", "640", "x480", "640x", "0x480", "640x-1", "640x480x3", "99999x1"})
    EXPECT_THROW(parse_size(text, "--size"), UsageError) << text;
}

TEST(AsUsage, TurnsErrorsIntoMistakesOnTheCommandLine) {
  EXPECT_EQ(as_usage([] { return 3; }), 3);
  EXPECT_THROW(as_usage([] { throw Error("a", "b", "c"); }), UsageError);
}

TEST(Progress, NeverLeavesItsLine) {
  const ProgressState state{123, 798, 120, 3, 2.5};
  for (int width = 1; width < 200; ++width)
    EXPECT_LE(progress_line(state, width).size(), static_cast<std::size_t>(width)) << width;
}

TEST(Progress, TellsCountsSpeedAndTimeToGo) {
  EXPECT_EQ(progress_line({123, 798, 120, 3, 2.5}, 100),
            "[######----------------------------------] 123/798  120 tracked, 3 lost  49.2 frames/s  ETA 0:14");
  EXPECT_EQ(progress_line({123, 798, 120, 3, 2.5}, 40), "123/798  120 tracked, 3 lost");
  EXPECT_EQ(progress_line({0, 0, 0, 0, 0}, 49), "[----------] 0/0  0 tracked, 0 lost  0.0 frames/s");
}

TEST(Duration, IsReadable) {
  EXPECT_EQ(duration_text(0), "0:00");
  EXPECT_EQ(duration_text(59.6), "1:00");
  EXPECT_EQ(duration_text(3723), "1:02:03");
  EXPECT_EQ(duration_text(-1), "0:00");
}

TEST(PathLength, SumsTheSteps) {
  Trajectory trajectory(3);
  trajectory[1].world_from_camera = SE3(Eigen::Quaterniond::Identity(), {3, 4, 0});
  trajectory[2].world_from_camera = SE3(Eigen::Quaterniond::Identity(), {3, 4, 1});
  EXPECT_DOUBLE_EQ(path_length(trajectory), 6);
  EXPECT_EQ(path_length({}), 0);
}

}  // namespace
}  // namespace plumbline::app
