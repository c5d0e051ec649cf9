// Stages and registrations in the device's own memory: on every device the same to the bit, and what the CPU gives.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <memory>
#include <new>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "backend/cuda/cuda.h"
#include "backend/registration.h"
#include "core/device_array.h"
#include "plumbline/error.h"
#include "simulated_device/devices.h"
#include "support/lane_types.h"
#include "support/registrations.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

using kernels::RegistrationState;

RegistrationState register_on(const Backend& backend, const test::RegistrationVariant& variant,
                              bool pass_by_pass = false) {
  test::RegistrationProblem problem(backend, variant.median_filter, test::pinhole(83, 61));
  variant.change(&problem.registration);
  return pass_by_pass ? run_passes(backend, problem.registration, SE3()) : backend.iterate(problem.registration, SE3());
}

void expect_same_bits(const RegistrationState& a, const RegistrationState& b) {
  EXPECT_EQ(a.model_from_live.rotation(), b.model_from_live.rotation());
  EXPECT_EQ(a.model_from_live.translation(), b.model_from_live.translation());
  EXPECT_EQ(a.median_distance, b.median_distance);
  EXPECT_EQ(std::memcmp(a.slots, b.slots, sizeof a.slots), 0);
  EXPECT_TRUE(std::equal(std::begin(a.iterations), std::end(a.iterations), b.iterations));
}

class SimulatedRegistration : public testing::TestWithParam<int> {
 protected:
  test::RegistrationVariant variant() const {
    return test::registration_variants()[static_cast<std::size_t>(GetParam())];
  }
};

TEST_P(SimulatedRegistration, SameBitsOnEveryDeviceAndThoseOfTheCpuNearly) {
  const RegistrationState on_cpu = register_on(*test::make_lanes("scalar"), variant());
  std::optional<RegistrationState> first;
  test::on_devices(0, 1, [&] {
    const RegistrationState found = register_on(*make_cuda_backend(), variant());
    if (first)
      expect_same_bits(*first, found);
    else
      first = found;
    EXPECT_LT((found.model_from_live.inverse() * on_cpu.model_from_live).log().norm(), 1e-5);
    EXPECT_TRUE(std::equal(std::begin(found.iterations), std::end(found.iterations), on_cpu.iterations));
    EXPECT_NEAR(found.inliers(), on_cpu.inliers(), 2);
  });
}

TEST_P(SimulatedRegistration, WithoutCooperativeLaunchesPassByPass) {
  const RegistrationState at_once = register_on(*make_cuda_backend(), variant());
  simulated::plug_in({.cooperative = false, .seed = 3});
  expect_same_bits(at_once, register_on(*make_cuda_backend(), variant()));
  expect_same_bits(at_once, register_on(*make_cuda_backend(), variant(), true));
}
INSTANTIATE_TEST_SUITE_P(Variants, SimulatedRegistration,
                         testing::Range(0, static_cast<int>(test::registration_variants().size())),
                         [](const auto& test) {
                           std::string name = test::registration_variants()[static_cast<std::size_t>(test.param)].name;
                           std::replace(name.begin(), name.end(), ' ', '_');
                           return name;
                         });

TEST(SimulatedStages, CompactAndScanOfAnyLength) {
  test::on_devices(0, 1, [] {
    const auto backend = make_cuda_backend();
    test::Random random(7);
    for (const int count : {1, 31, 32, 33, 1000}) {
      for (const double share : {0.0, 0.3, 1.0}) {
        std::vector<std::int32_t> flags, expected, sums;
        for (int i = 0; i < count; ++i) {
          sums.push_back(static_cast<std::int32_t>(expected.size()));
          flags.push_back(random.uniform(0, 1) < share ? 1 : 0);
          if (flags.back() != 0) expected.push_back(i);
        }
        const DeviceArray<std::int32_t> on_device(*backend, flags), list(*backend, flags.size());
        ASSERT_EQ(backend->compact(on_device.data(), count, list.data()), static_cast<int>(expected.size()));
        EXPECT_EQ(list.download(*backend, expected.size()), expected);
        EXPECT_EQ(backend->scan(on_device.data(), count), static_cast<std::int64_t>(expected.size()));
        EXPECT_EQ(on_device.download(*backend), sums);
      }
    }
    const DeviceArray<std::int32_t> many(*backend, std::vector<std::int32_t>(3, 1 << 30));
    EXPECT_THROW(backend->scan(many.data(), 3), Error);
  });
}

TEST(SimulatedStages, UploadsOfAnySizeArriveInOrder) {
  test::on_devices(0, 2, [] {
    const auto backend = make_cuda_backend();
    const DeviceArray<int> large(*backend, std::size_t{5} << 20);  // more than is staged
    std::vector<int> values(large.size());
    for (int round = 0; round < 2; ++round) {
      std::iota(values.begin(), values.end(), round);
      backend->upload(large.data(), values.data(), values.size() * sizeof(int));
      values.assign(values.size(), -1);  // the caller may change its memory at once
    }
    for (int i = 0; i < 12; ++i) backend->upload(large.data() + i, &i, sizeof i);
    const std::vector<int> back = large.download(*backend);
    for (int i = 0; i < 12; ++i) EXPECT_EQ(back[static_cast<std::size_t>(i)], i);
    EXPECT_EQ(back[12], 13);
    EXPECT_EQ(back.back(), static_cast<int>(back.size()));
  });
}

TEST(SimulatedStages, NothingToDoIsDone) {
  test::on_devices(0, 1, [] {
    const auto backend = make_cuda_backend();
    const DeviceArray<std::int32_t> one(*backend, 1), listed(*backend, 1);
    EXPECT_EQ(backend->compact(one.data(), 0, one.data()), 0);
    EXPECT_EQ(backend->scan(one.data(), 0), 0);
    backend->integrate_marked({}, one.data(), 0, one.data(), listed.data());
    backend->run(kernels::CountBrick{}, 0);
    backend->run(kernels::WriteBrick{}, 0);
    backend->run(kernels::BilateralFilter{});
    backend->run(kernels::MarkBricks{});
    backend->run(kernels::RaySpans{});
    EXPECT_EQ(backend->reduce(kernels::IcpReduce{}).inliers(), 0);
    EXPECT_EQ(backend->reduce(kernels::CompareDepth{}).known(), 0);
    backend->wait();
  });
}

TEST(SimulatedStages, AnErrorIsToldOnce) {
  const auto backend = make_cuda_backend();
  EXPECT_THROW(backend->allocate(std::size_t{1} << 40), std::bad_alloc);
  const DeviceArray<int> values(*backend, std::vector<int>{1, 2, 3});
  EXPECT_EQ(values.download(*backend), (std::vector<int>{1, 2, 3}));
  kernels::IcpReduce too_fine;
  too_fine.in.bins = 1 << 20;
  EXPECT_THROW(backend->reduce(too_fine), Error);
  EXPECT_GE(backend->milliseconds([&] { backend->clear(values.data(), sizeof(int)); }), 0);
  EXPECT_EQ(values.download(*backend), (std::vector<int>{0, 2, 3}));
}

TEST(SimulatedStages, ABackendMayGoWhileItWorks) {
  test::on_devices(0, 1, [] {
    auto backend = make_cuda_backend();
    const DeviceArray<int> values(*backend, std::vector<int>(100, 1));
    for (int i = 0; i < 3; ++i) backend->upload(values.data(), &i, sizeof i);
    values.clear(*backend);
    backend.reset();
  });
}

}  // namespace
}  // namespace plumbline
