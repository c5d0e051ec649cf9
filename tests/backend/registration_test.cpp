// A frame's registration on every backend: without the host between the passes as with it, on a device as on the CPU.
#include "backend/registration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <list>
#include <numeric>

#include "plumbline/angles.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "support/lane_types.h"
#include "support/registrations.h"

namespace plumbline {
namespace {

using Problem = test::RegistrationProblem;
using Variant = test::RegistrationVariant;

kernels::RegistrationState iterate(const Backend& backend, const Variant& variant) {
  Problem problem(backend, variant.median_filter);
  variant.change(&problem.registration);
  return backend.iterate(problem.registration, SE3());
}

class RegistrationTest : public test::LaneTest {};
PLUMBLINE_ON_EVERY_LANE_TYPE(RegistrationTest);

TEST_P(RegistrationTest, WithoutTheHostAsWithIt) {
  for (const Variant& variant : test::registration_variants()) {
    SCOPED_TRACE(variant.name);
    Problem problem(backend(), variant.median_filter);
    variant.change(&problem.registration);
    int told = 0;
    const kernels::RegistrationState alone = backend().iterate(problem.registration, SE3());
    const kernels::RegistrationState with_host =
        run_passes(backend(), problem.registration, SE3(),
                   [&](const kernels::RegistrationState&, const IcpSums&, int) { ++told; });
    EXPECT_EQ(told, std::accumulate(std::begin(alone.iterations), std::end(alone.iterations), 0));
    EXPECT_TRUE(std::equal(std::begin(alone.iterations), std::end(alone.iterations), with_host.iterations));
    EXPECT_EQ(alone.rank, with_host.rank);
    EXPECT_EQ(alone.next.level, with_host.next.level);
    EXPECT_EQ(alone.median_distance, with_host.median_distance);
    // A device solves by its own sine and rounding, so that the estimates agree to a few digits less than all.
    EXPECT_LT((alone.model_from_live.inverse() * with_host.model_from_live).log().norm(), 1e-7);
    EXPECT_NEAR(alone.inliers(), with_host.inliers(), 2);
  }
}

TEST_P(RegistrationTest, RepeatsToTheBit) {
  for (const Variant& variant : test::registration_variants()) {
    const kernels::RegistrationState once = iterate(backend(), variant), again = iterate(backend(), variant);
    EXPECT_EQ(once.model_from_live.rotation(), again.model_from_live.rotation()) << variant.name;
    EXPECT_EQ(once.model_from_live.translation(), again.model_from_live.translation()) << variant.name;
    EXPECT_EQ(std::memcmp(once.slots, again.slots, sizeof once.slots), 0) << variant.name;
  }
}

TEST_P(RegistrationTest, FindsTheMotionAsThePlainLaneDoes) {
  const std::shared_ptr<Backend> plain = test::make_lanes("scalar");
  for (const Variant& variant : test::registration_variants()) {
    SCOPED_TRACE(variant.name);
    const kernels::RegistrationState here = iterate(backend(), variant), there = iterate(*plain, variant);
    EXPECT_LT((here.model_from_live.inverse() * there.model_from_live).log().norm(), 2e-4);
    EXPECT_EQ(here.rank, there.rank);
  }
  const Problem problem(backend(), false);
  const kernels::RegistrationState found = backend().iterate(problem.registration, SE3());
  EXPECT_LT((found.model_from_live.inverse() * problem.truth).translation().norm(), 2e-3);
  EXPECT_LT(so3::angle(found.model_from_live.rotation().transpose() * problem.truth.rotation()),
            0.05 * kRadiansPerDegree);
}

// ---- what happens between the passes, without a backend ------------------------------------------------------------

/// Sums as if every pass had found the same: a system whose solution is `step`, `matched` pixels of `pairs`.
std::vector<double> sums(const Vector6d& step, double matched, double pairs) {
  std::vector<double> slots(kernels::icp_sum::kCount, 0);
  int slot = kernels::icp_sum::kHessian;
  for (int i = 0; i < 6; ++i)
    for (int j = i; j < 6; ++j) slots[static_cast<std::size_t>(slot++)] = i == j ? 1 : 0;
  for (int i = 0; i < 6; ++i) slots[static_cast<std::size_t>(kernels::icp_sum::kGradient + i)] = step[i];
  slots[kernels::icp_sum::kInliers] = matched;
  slots[kernels::icp_sum::kPairs] = pairs;
  return slots;
}

kernels::Registration two_levels() {
  kernels::Registration r;
  r.level_count = 2;
  r.rules.bins = 100;
  r.rules.bins_per_metre = 100;
  r.rules.distance_gate = 0.1;
  r.rules.max_condition = 1e6;
  r.levels[0].iterations = 2;
  r.levels[1].iterations = 3;
  r.levels[0].pixels = r.levels[1].pixels = 1000;
  return r;
}

TEST(Advance, GoesThroughTheLevelsAndTellsTheLastDistribution) {
  const kernels::Registration r = two_levels();
  const std::vector<double> slots = sums(Vector6d::Constant(0.01), 500, 600);
  kernels::RegistrationState s = kernels::begin(r, SE3());
  for (int pass = 0; pass < 5; ++pass) {
    EXPECT_EQ(s.next.task, kernels::RegistrationTask::pass);
    EXPECT_EQ(s.next.level, pass < 2 ? 0 : 1);
    EXPECT_EQ(s.next.in.bins, pass == 4 ? 100 : 0) << "counted only where it is told";
    kernels::advance(r, slots.data(), pass == 4 ? 7 : -1, &s);
  }
  EXPECT_EQ(s.next.task, kernels::RegistrationTask::finished);
  EXPECT_DOUBLE_EQ(s.median_distance, 0.075);
  EXPECT_EQ(s.iterations[0], 2);
  EXPECT_EQ(s.iterations[1], 3);
  EXPECT_EQ(s.rank, 6);
}

TEST(Advance, EndsSoonerWhereTheStepIsSmallOrNothingMatches) {
  kernels::Registration r = two_levels();
  r.rules.converged_step = 1e-3;
  r.rules.max_iterations = 10;
  const std::vector<double> still = sums(Vector6d::Zero(), 500, 600), moves = sums(Vector6d::Constant(0.01), 500, 600);
  kernels::RegistrationState s = kernels::begin(r, SE3());
  while (s.next.task != kernels::RegistrationTask::finished) kernels::advance(r, still.data(), 3, &s);
  EXPECT_EQ(s.iterations[0], 2) << "at least these";
  EXPECT_EQ(s.iterations[1], 3);
  s = kernels::begin(r, SE3());
  while (s.next.task != kernels::RegistrationTask::finished) kernels::advance(r, moves.data(), 3, &s);
  EXPECT_EQ(s.iterations[0], 10) << "at most these";
  r.levels[0].min_inliers = r.levels[1].min_inliers = 600;
  s = kernels::begin(r, SE3());
  int last = 0;
  while (s.next.task != kernels::RegistrationTask::finished) {
    last += s.next.task == kernels::RegistrationTask::final_distribution ? 1 : 0;
    kernels::advance(r, moves.data(), 3, &s);
  }
  EXPECT_EQ(s.iterations[0], 1);
  EXPECT_EQ(s.iterations[1], 1);
  EXPECT_EQ(last, 1) << "it came sooner than expected";
}

TEST(Advance, AsksForACorrectionWhereTheMedianMoved) {
  kernels::Registration r = two_levels();
  r.rules.median_filter = r.rules.every_distribution = true;
  r.rules.median_band = 0.02;
  const std::vector<double> slots = sums(Vector6d::Zero(), 500, 600), changes = sums(Vector6d::Zero(), 20, 0);
  kernels::RegistrationState s = kernels::begin(r, SE3());
  EXPECT_FLOAT_EQ(s.next.in.band_high, 0.02f);
  kernels::advance(r, slots.data(), 4, &s);
  ASSERT_EQ(s.next.task, kernels::RegistrationTask::correction);
  EXPECT_FLOAT_EQ(s.next.from_high, 0.02f);
  EXPECT_FLOAT_EQ(s.next.in.band_high, 0.065f);
  kernels::advance(r, changes.data(), -1, &s);
  EXPECT_EQ(s.inliers(), 520);
  ASSERT_EQ(s.next.task, kernels::RegistrationTask::pass);
  kernels::advance(r, slots.data(), 4, &s);
  EXPECT_EQ(s.next.task, kernels::RegistrationTask::pass) << "the same median: nothing to correct";
  EXPECT_EQ(s.iterations[0], 2);
}

TEST(MedianBin, IsTheFirstThatHoldsHalf) {
  EXPECT_EQ(kernels::median_bin(std::vector<int>{}.data(), 0), -1);
  for (const auto& [counts, expected] : std::vector<std::pair<std::vector<int>, int>>{
           {{0, 0}, -1}, {{1, 0, 0}, 0}, {{0, 0, 1}, 2}, {{1, 1}, 0}, {{1, 2}, 1}, {{3, 0, 3}, 0}, {{2, 0, 3}, 2}})
    EXPECT_EQ(kernels::median_bin(counts.data(), static_cast<int>(counts.size())), expected);
}

}  // namespace
}  // namespace plumbline
