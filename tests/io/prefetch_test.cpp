#include "plumbline/prefetch.h"

#include <gmock/gmock.h>

#include <atomic>
#include <chrono>
#include <numeric>

#include "plumbline/error.h"
#include "plumbline/frame.h"
#include "plumbline/image.h"
#include "plumbline/time.h"
#include "support/data.h"

namespace plumbline {
namespace {

using std::chrono::milliseconds;

/// Frames that say who they are, and reads that can fail or take long.
class FakeSequence : public Sequence {
 public:
  explicit FakeSequence(int n, int bad = -1, milliseconds duration = milliseconds(0))
      : Sequence({}, times(n)), bad_(bad), duration_(duration) {}

  ImuRecording read_imu(std::vector<std::string>*) const override { return {}; }
  Frame read(int index) const override {
    ++reads;
    std::this_thread::sleep_for(duration_);
    if (index == bad_) throw Error("is damaged", "frame " + std::to_string(index), "");
    Frame frame;
    frame.index = index;
    frame.time = time(index);
    frame.depth = DepthImage(4, 4);
    return frame;
  }

  mutable std::atomic<int> reads = 0;

 private:
  static std::vector<Nanoseconds> times(int n) {
    std::vector<Nanoseconds> t(static_cast<std::size_t>(n));
    std::iota(t.begin(), t.end(), 100);
    return t;
  }
  int bad_;
  milliseconds duration_;
};

TEST(Prefetcher, GivesTheFramesInOrder) {
  const FakeSequence sequence(50);
  std::vector<int> indices;
  for (int i = 49; i >= 0; i -= 3) indices.push_back(i);
  for (const int ahead : {1, 4, 100}) {
    Prefetcher prefetcher(sequence, indices, ahead);
    for (const int i : indices) {
      const auto frame = prefetcher.next();
      ASSERT_TRUE(frame);
      EXPECT_EQ(frame->index, i);
      EXPECT_EQ(frame->time, 100 + i);
    }
    EXPECT_FALSE(prefetcher.next());
    EXPECT_FALSE(prefetcher.next());
  }
}

TEST(Prefetcher, AnErrorComesInItsTurnAndTheRestFollows) {
  const FakeSequence sequence(6, 2);
  Prefetcher prefetcher(sequence, {0, 1, 2, 3, 99, 4}, 3);
  EXPECT_EQ(prefetcher.next()->index, 0);
  EXPECT_EQ(prefetcher.next()->index, 1);
  EXPECT_THROW(prefetcher.next(), Error);
  EXPECT_EQ(prefetcher.next()->index, 3);
  EXPECT_THROW(prefetcher.next(), std::out_of_range);  // there is no frame 99
  EXPECT_EQ(prefetcher.next()->index, 4);
  EXPECT_FALSE(prefetcher.next());
}

TEST(Prefetcher, DecodesAheadButNoFartherThanAsked) {
  const FakeSequence sequence(100);
  std::vector<int> indices(100);
  std::iota(indices.begin(), indices.end(), 0);
  Prefetcher prefetcher(sequence, indices, 4);
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (sequence.reads < 4 && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(milliseconds(1));
  std::this_thread::sleep_for(milliseconds(50));
  EXPECT_EQ(sequence.reads, 4);
  prefetcher.next();
  while (sequence.reads < 5 && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(milliseconds(1));
  std::this_thread::sleep_for(milliseconds(50));
  EXPECT_EQ(sequence.reads, 5);
}

TEST(Prefetcher, DestructionInTheMidstIsPrompt) {
  const FakeSequence sequence(1000, -1, milliseconds(20));
  std::vector<int> indices(1000);
  std::iota(indices.begin(), indices.end(), 0);
  const auto start = std::chrono::steady_clock::now();
  {
    Prefetcher prefetcher(sequence, indices, 1000);
    EXPECT_EQ(prefetcher.next()->index, 0);
    EXPECT_GE(prefetcher.decode_milliseconds(), 19);
    EXPECT_GE(prefetcher.wait_milliseconds(), 0);
  }
  { const Prefetcher unused(sequence, indices, 1); }
  // All thousand frames would take 20 s.
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
  EXPECT_LT(sequence.reads, 100);
}

TEST(Prefetcher, NothingToDo) {
  const FakeSequence sequence(3);
  Prefetcher prefetcher(sequence, {});
  EXPECT_FALSE(prefetcher.next());
}

TEST(Prefetcher, GivesWhatReadGives) {
  PLUMBLINE_DATA_OR_SKIP(folder, "tum/rgbd_dataset_freiburg1_desk_9frames");
  const auto sequence = open_sequence(folder.string());
  Prefetcher prefetcher(*sequence, {0, 4, 8}, 2);
  for (const int i : {0, 4, 8}) {
    const auto frame = prefetcher.next();
    ASSERT_TRUE(frame);
    const Frame expected = sequence->read(i);
    EXPECT_EQ(frame->time, expected.time);
    EXPECT_TRUE(frame->depth.pixels == expected.depth.pixels);
    EXPECT_TRUE(frame->color.pixels == expected.color.pixels);
  }
}

}  // namespace
}  // namespace plumbline
