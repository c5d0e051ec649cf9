// A recording in real time, from a source whose frames are nothing but stamps.
#include "run/realtime_source.h"
#include "plumbline/frame.h"
#include "plumbline/time.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

namespace plumbline::app {
namespace {

using Clock = std::chrono::steady_clock;
constexpr Nanoseconds kPeriod = 10'000'000;

/// `count` frames, ten milliseconds apart.
class Stamps : public FrameSource {
 public:
  explicit Stamps(int count) : count_(count) {}
  SequenceInfo info() const override { return {}; }
  std::vector<std::string> describe() const override { return {}; }
  bool has_color() const override { return false; }
  int total() const override { return count_; }
  std::optional<Frame> next(const std::function<bool()>& stopping) override {
    if (stopping() || next_ == count_) return std::nullopt;
    Frame frame;
    frame.index = next_++;
    frame.time = 5 * kNanosecondsPerSecond + frame.index * kPeriod;
    return frame;
  }
  ReadTimes read_times() const override { return {0, static_cast<double>(next_ - 1)}; }
  std::optional<OrientationReading> reading() const override { return std::nullopt; }
  std::optional<OrientationStreamOptions> orientation() const override { return std::nullopt; }

 private:
  int count_, next_ = 0;
};

bool never() { return false; }

TEST(RealtimeSource, DropsWhatCameWhileAFrameWasWorkedOn) {
  RealtimeSource source(std::make_unique<Stamps>(30), 1);
  std::vector<int> given;
  while (const std::optional<Frame> frame = source.next(never)) {
    EXPECT_EQ(source.read_times().decode, frame->index) << "the times are another frame's";
    given.push_back(frame->index);
    std::this_thread::sleep_for(std::chrono::milliseconds(35));
  }
  ASSERT_FALSE(given.empty());
  EXPECT_EQ(given.front(), 0);
  EXPECT_EQ(given.back(), 29) << "the last frame stays until it is taken";
  // Three frames go by in 35 ms, or more where the machine is busy.
  for (std::size_t i = 1; i + 1 < given.size(); ++i) EXPECT_GE(given[i] - given[i - 1], 3);
  const LiveCounts counts = *source.live();
  EXPECT_EQ(counts.captured, 30U);
  EXPECT_EQ(counts.dropped, 30 - given.size());
}

TEST(RealtimeSource, GivesNoFrameBeforeItsTime) {
  for (const double speed : {1.0, 2.0}) {
    RealtimeSource source(std::make_unique<Stamps>(6), speed);
    Clock::time_point start;
    while (const std::optional<Frame> frame = source.next(never)) {
      if (frame->index == 0) start = Clock::now();
      const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
      // The clock of the source began a little before the first frame came out.
      EXPECT_GE(seconds + 2e-3, 1e-2 * frame->index / speed);
    }
  }
}

TEST(RealtimeSource, StopsInAGapOfTheRecording) {
  RealtimeSource source(std::make_unique<Stamps>(2), 1e-4);  // the second frame is due after 100 s
  ASSERT_TRUE(source.next(never));
  const Clock::time_point limit = Clock::now() + std::chrono::milliseconds(20);
  EXPECT_FALSE(source.next([&] { return Clock::now() > limit; }));
}

TEST(RealtimeSource, OfNothingGivesNothing) {
  RealtimeSource source(std::make_unique<Stamps>(0), 1);
  EXPECT_FALSE(source.next(never));
  EXPECT_EQ(source.live()->captured, 0U);
}

TEST(RealtimeSource, LosesNothingWhileTheRunStandsStill) {
  RealtimeSource source(std::make_unique<Stamps>(3), 0.05);  // a frame each 200 ms: a busy machine keeps up
  source.next(never);
  const Clock::time_point stop = Clock::now();
  std::this_thread::sleep_for(std::chrono::milliseconds(450));
  source.delay((Clock::now() - stop) / std::chrono::nanoseconds(1));
  EXPECT_EQ(source.next(never)->index, 1) << "two frames would have gone by";
  EXPECT_EQ(source.live()->dropped, 0U);
}

}  // namespace
}  // namespace plumbline::app
