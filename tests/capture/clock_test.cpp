#include "capture/clock.h"
#include "plumbline/time.h"

#include <gtest/gtest.h>

#include <random>

namespace plumbline::capture {
namespace {

constexpr Nanoseconds kMs = 1'000'000, kFrame = 33 * kMs;

TEST(DeviceClock, TakesTheJitterOfDeliveryOut) {
  DeviceClock clock;
  std::mt19937 random(1);
  const Nanoseconds offset = 5000 * kMs, shortest = 2 * kMs;
  for (int i = 0; i < 300; ++i) {
    const Nanoseconds device = i * kFrame, truth = device + offset;
    const Nanoseconds arrival = truth + shortest + static_cast<Nanoseconds>(random() % (30 * kMs));
    const Nanoseconds host = clock.to_host(device, arrival);
    EXPECT_LE(host, arrival);
    if (i > 30) {
      EXPECT_NEAR(static_cast<double>(host - truth), shortest, 3.0 * kMs);
    }
  }
  EXPECT_EQ(clock.jumps(), 0);
}

TEST(DeviceClock, FollowsADriftingQuartz) {
  DeviceClock clock;
  Nanoseconds worst = 0;
  for (int i = 0; i < 20000; ++i) {  // eleven minutes
    const Nanoseconds truth = i * kFrame;
    const auto device = static_cast<Nanoseconds>(static_cast<double>(truth) * (1 - 5e-5));
    worst = std::max(worst, std::abs(clock.to_host(device, truth + (i % 10) * kMs) - truth));
  }
  EXPECT_LT(worst, 2 * kMs);
  EXPECT_EQ(clock.jumps(), 0);
}

/// Frames 0…19 before the device's clock jumps by `jump`, 20…59 after; returns the worst error from frame `from` on.
Nanoseconds worst_after_jump(DeviceClock& clock, Nanoseconds jump, int from) {
  Nanoseconds worst = 0, last = -1;
  for (int i = 0; i < 60; ++i) {
    const Nanoseconds arrival = 1000 * kMs + i * kFrame;
    const Nanoseconds host = clock.to_host(i * kFrame + (i < 20 ? 0 : jump) + 3600 * kNanosecondsPerSecond, arrival);
    EXPECT_GT(host, last) << "frame " << i;
    EXPECT_LE(host, arrival);
    last = host;
    if (i >= from) worst = std::max(worst, arrival - host);
  }
  return worst;
}

TEST(DeviceClock, SurvivesJumps) {
  for (const Nanoseconds jump : {-3600 * kNanosecondsPerSecond, -kNanosecondsPerSecond, kNanosecondsPerSecond}) {
    DeviceClock clock;
    EXPECT_LT(worst_after_jump(clock, jump, 20), kMs) << jump;
    EXPECT_EQ(clock.jumps(), 1) << jump;
  }
  DeviceClock late;  // one that seems late might be: believed after a few frames
  EXPECT_LT(worst_after_jump(late, -kNanosecondsPerSecond / 4, 25), kMs);
}

TEST(DeviceClock, ADelayedReadingIsNoJump) {
  DeviceClock clock;
  for (int i = 0; i < 10; ++i) clock.to_host(i * kFrame, i * kFrame);
  // The program was held up for half a second; two frames waited.
  EXPECT_EQ(clock.to_host(10 * kFrame, 10 * kFrame + 500 * kMs), 10 * kFrame);
  EXPECT_EQ(clock.to_host(11 * kFrame, 10 * kFrame + 501 * kMs), 11 * kFrame);
  EXPECT_NEAR(static_cast<double>(clock.to_host(30 * kFrame, 30 * kFrame)), 30.0 * kFrame, kMs);
  EXPECT_EQ(clock.jumps(), 0);
}

TEST(Clock, UnixOffsetIsOfThisCentury) {
  const double years = to_seconds(now() + unix_offset()) / (365.25 * 86400);
  EXPECT_GT(years, 50);
  EXPECT_LT(years, 130);
}

}  // namespace
}  // namespace plumbline::capture
