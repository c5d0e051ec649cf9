// The launchers' own arithmetic: prefix sums and compaction, against brute force, where chunks begin
// and end, with one thread and several.
#include <tbb/global_control.h>

#include <cstdint>
#include <limits>
#include <numeric>

#include "plumbline/error.h"
#include "plumbline/image.h"
#include "support/lane_types.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

constexpr int kSizes[] = {0, 1, 2, 16383, 16384, 16385, 32768, 100000};

class Scan : public testing::TestWithParam<int> {
 protected:
  Scan() : backend_(make_cpu_backend(GetParam())) {}
  const Backend& backend() const { return *backend_; }

 private:
  // A machine with fewer cores would otherwise be given fewer threads.
  tbb::global_control threads_{tbb::global_control::max_allowed_parallelism, 7};
  std::shared_ptr<Backend> backend_;
};

TEST_P(Scan, CompactListsTheMarkedInOrder) {
  test::Random random(1);
  for (const int size : kSizes) {
    for (const double density : {0.0, 0.03, 0.5, 1.0}) {
      std::vector<std::int32_t> flags(static_cast<std::size_t>(size)), expected;
      for (int i = 0; i < size; ++i) {
        if (random.uniform(0, 1) >= density) continue;
        flags[static_cast<std::size_t>(i)] = i % 3 == 0 ? 1 : (i % 3 == 1 ? -5 : 1 << 30);  // anything but zero
        expected.push_back(i);
      }
      std::vector<std::int32_t> list(expected.size() + 4, -77);
      ASSERT_EQ(backend().compact(flags.data(), size, list.data()), static_cast<int>(expected.size()));
      ASSERT_TRUE(std::equal(expected.begin(), expected.end(), list.begin())) << size;
      for (std::size_t i = expected.size(); i < list.size(); ++i) ASSERT_EQ(list[i], -77) << "written past the end";
    }
  }
}

TEST_P(Scan, ScanIsTheExclusivePrefixSum) {
  test::Random random(2);
  for (const int size : kSizes) {
    std::vector<std::int32_t> values(static_cast<std::size_t>(size));
    for (std::int32_t& value : values) value = random.integer(0, 20000);
    std::vector<std::int64_t> expected(values.size());
    std::exclusive_scan(values.begin(), values.end(), expected.begin(), std::int64_t{0});
    const std::int64_t total = std::accumulate(values.begin(), values.end(), std::int64_t{0});
    values.push_back(-77);
    ASSERT_EQ(backend().scan(values.data(), size), total);
    ASSERT_EQ(values.back(), -77) << "written past the end";
    for (std::size_t i = 0; i < expected.size(); ++i) ASSERT_EQ(values[i], expected[i]) << size << ", " << i;
  }
}

TEST_P(Scan, ATotalThatThirtyTwoBitsCannotHoldIsAnError) {
  constexpr std::int32_t kMax = std::numeric_limits<std::int32_t>::max();
  std::vector<std::int32_t> just{kMax - 5, 2, 3};
  EXPECT_EQ(backend().scan(just.data(), 3), kMax);
  EXPECT_EQ(just, (std::vector<std::int32_t>{0, kMax - 5, kMax - 3}));
  std::vector<std::int32_t> over{kMax, 1};
  EXPECT_THROW(backend().scan(over.data(), 2), Error);
  std::vector<std::int32_t> many(100000, 30000);  // no chunk overflows, the sum of the chunks does
  EXPECT_THROW(backend().scan(many.data(), 100000), Error);
}

INSTANTIATE_TEST_SUITE_P(Threads, Scan, testing::Values(1, 2, 7), testing::PrintToStringParamName());

TEST(CpuBackend, KnowsItsInstructionSets) {
  const std::vector<std::string> sets = cpu_instruction_sets();
  ASSERT_FALSE(sets.empty());
  for (const std::string& set : sets) {
    const auto backend = make_cpu_backend(3, set);
    EXPECT_EQ(backend->name(), "cpu");
    EXPECT_EQ(backend->description(), "cpu (" + set + ", 3 threads)");
  }
  EXPECT_EQ(make_cpu_backend(1)->description(), "cpu (" + sets.front() + ", 1 thread)");
  EXPECT_THROW(make_cpu_backend(1, "avx1024"), Error);
}

TEST(CpuBackend, IsFoundByName) {
  EXPECT_EQ(make_backend("auto", 1)->name(), "cpu");
  EXPECT_EQ(make_backend("cpu", 1)->name(), "cpu");
  EXPECT_THROW(make_backend("abacus"), Error);
  bool listed = false;
  for (const BackendInfo& info : list_backends()) {
    listed |= info.name == "cpu" && info.available;
    if (info.available) continue;
    EXPECT_THROW(make_backend(info.name), Error);
    EXPECT_FALSE(info.description.empty()) << "why it is not available";
  }
  EXPECT_TRUE(listed);
}

TEST(CpuBackend, MemoryIsZeroedAndCopied) {
  const auto backend = make_cpu_backend(1);
  std::vector<std::uint8_t> bytes(100003), back(bytes.size());
  const DeviceArray<std::uint8_t> array(*backend, bytes.size());
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(array.data()) % 64, 0u);
  backend->download(back.data(), array.data(), back.size());
  EXPECT_EQ(back, bytes) << "not zero";
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{1});
  backend->upload(array.data(), bytes.data(), bytes.size());
  backend->download(back.data(), array.data(), back.size());
  EXPECT_EQ(back, bytes);
  backend->clear(array.data(), bytes.size() - 1);
  backend->download(back.data(), array.data(), back.size());
  EXPECT_EQ(std::count(back.begin(), back.end() - 1, 0), static_cast<std::ptrdiff_t>(back.size() - 1));
  EXPECT_EQ(back.back(), bytes.back()) << "cleared too much";
}

}  // namespace
}  // namespace plumbline
