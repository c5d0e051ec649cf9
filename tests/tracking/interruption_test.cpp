#include "tracking/interruption.h"

#include <gtest/gtest.h>

namespace plumbline {
namespace {

constexpr double kMaxGap = 0.25;

FrameIntervals frames_every(double seconds) {
  FrameIntervals intervals;
  for (int i = 0; i < 10; ++i) intervals.observe(from_seconds(seconds * i));
  return intervals;
}

bool interrupted(FrameIntervals intervals, double previous, double now) {
  intervals.observe(from_seconds(now));
  return intervals.is_interrupted(from_seconds(previous), from_seconds(now), kMaxGap);
}

TEST(FrameIntervals, AGapIsLongerThanTheLimitAndThanUsual) {
  EXPECT_FALSE(interrupted(frames_every(0.03), 0.27, 0.5));
  EXPECT_TRUE(interrupted(frames_every(0.03), 0.27, 0.53));
  EXPECT_FALSE(interrupted(frames_every(0.5), 4.5, 5.0)) << "every 15th frame";
  EXPECT_FALSE(interrupted(frames_every(0.5), 4.5, 5.5)) << "one of them missing";
  EXPECT_TRUE(interrupted(frames_every(0.5), 4.5, 6.0));
}

TEST(FrameIntervals, LostFramesCountByTheirTime) {
  EXPECT_TRUE(interrupted(frames_every(0.03), 0.0, 0.3)) << "the previous accepted frame was ten frames ago";
}

TEST(FrameIntervals, ASlowRecordingIsInterruptedByOneLostFrame) {
  FrameIntervals intervals = frames_every(0.5);
  intervals.observe(from_seconds(5.0));
  EXPECT_TRUE(interrupted(intervals, 4.5, 5.5)) << "that at 5.0 was lost";
  EXPECT_FALSE(interrupted(intervals, 5.0, 5.5));
}

TEST(FrameIntervals, AClockThatGoesBackIsAnInterruption) {
  EXPECT_TRUE(interrupted(frames_every(0.03), 0.27, -5.0));
  EXPECT_FALSE(interrupted(frames_every(0), 0, 0)) << "stamps that say nothing";
}

TEST(FrameIntervals, TheFirstIntervalIsTheUsualOne) {
  FrameIntervals intervals;
  intervals.observe(0);
  EXPECT_FALSE(interrupted(intervals, 0, 2.0));
}

}  // namespace
}  // namespace plumbline
