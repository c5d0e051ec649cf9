// The simulated device itself: each kind of mistake is found, for every seed, and the same work without it is not.
#include "simulated_device/device.h"

#include <gmock/gmock.h>

#include <functional>

#include "backend/cuda/cuda.h"
#include "core/device_array.h"
#include "plumbline/error.h"
#include "simulated_device/faulty_kernels.h"

namespace plumbline {
namespace {

using simulated::Mistake;
using testing::Contains;
using testing::HasSubstr;

struct Case {
  Mistake mistake;
  const char* name;
  const char* said;
};
const Case kCases[] = {
    {Mistake::missing_barrier, "MissingBarrier", "no barrier or event is between"},
    {Mistake::missing_warp_barrier, "MissingWarpBarrier", "no barrier or event is between"},
    {Mistake::missing_grid_barrier, "MissingGridBarrier", "no barrier or event is between"},
    {Mistake::barrier_of_some, "BarrierOfSome", "wait for each other at different places"},
    {Mistake::storage_used_again, "StorageUsedAgain", "used again without a barrier"},
    {Mistake::plain_count, "PlainCount", "no barrier or event is between"},
    {Mistake::beyond_the_array, "BeyondTheArray", "belongs to no allocation"},
    {Mistake::beyond_shared_memory, "BeyondSharedMemory", "beyond the shared memory that its launch gives it"},
    {Mistake::unwritten, "Unwritten", "what nobody has written"},
    {Mistake::host_pointer, "HostPointer", "reads the host's memory in a kernel"},
    {Mistake::freed, "Freed", "belongs to no allocation (or no longer)"},
    {Mistake::missing_wait, "MissingWait", "no barrier or event is between"},
    {Mistake::missing_event, "MissingEvent", "no barrier or event is between"},
    {Mistake::source_changed, "SourceChanged", "the host changed what a copy to the device was still to read"},
    {Mistake::pinned_freed, "PinnedFreed", "belongs to no allocation (or no longer)"},
    {Mistake::wrong_side, "WrongSide", "reads what is not on its side"},
};

class SimulatedMistake : public testing::TestWithParam<Case> {};

/// Seeds out of `seeds` with which the device says `said` (by whatever processors).
int times_found(Mistake mistake, const char* said, int seeds) {
  int found = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    simulated::plug_in({.processors = 1 + seed % 3, .seed = static_cast<std::uint64_t>(seed)});
    simulated::sum_with(mistake);
    const std::vector<std::string> faults = simulated::take_faults();
    found += testing::Matches(Contains(HasSubstr(said)))(faults) ? 1 : 0;
  }
  return found;
}

TEST_P(SimulatedMistake, IsFound) {
  const Case& c = GetParam();
  // What is not waited for is there all the same if the device was quick.
  const bool depends = c.mistake == Mistake::source_changed || c.mistake == Mistake::pinned_freed;
  EXPECT_GE(times_found(c.mistake, c.said, 20), depends ? 5 : 20);
}
INSTANTIATE_TEST_SUITE_P(All, SimulatedMistake, testing::ValuesIn(kCases),
                         [](const auto& test) { return test.param.name; });

TEST(SimulatedDevice, FindsNothingInWhatIsRight) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    simulated::plug_in({.seed = seed});
    EXPECT_EQ(simulated::sum_with(Mistake::none), 255 * 256 / 2) << seed;
    EXPECT_THAT(simulated::take_faults(), testing::IsEmpty()) << seed;
  }
}

TEST(SimulatedDevice, TheHostCannotTouchItsMemory) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto backend = make_cuda_backend();
  const DeviceArray<int> values(*backend, std::vector<int>{1, 2, 3});
  EXPECT_TRUE(simulated::is_device_address(values.data()));
  EXPECT_DEATH(*static_cast<volatile int*>(values.data()) = 1,
               "the host's code touched byte 0 of an allocation of 12 bytes");
  EXPECT_DEATH(simulated::sum_with(Mistake::device_pointer), "the host's code touched byte 0");
  EXPECT_EQ(values.download(*backend), (std::vector<int>{1, 2, 3}));
}

TEST(SimulatedDevice, IsTheOneThatIsThere) {
  EXPECT_EQ(make_backend("cuda")->description(), "cuda (simulated device)");
  EXPECT_EQ(make_backend("auto")->name(), "cpu") << "until it was seen to work on a real one";
  simulated::plug_in({.available = false});
  EXPECT_THROW(make_cuda_backend(), Error);
  EXPECT_EQ(cuda_info().description, "no CUDA device: there is no NVIDIA driver");
}

}  // namespace
}  // namespace plumbline
