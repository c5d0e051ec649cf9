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
#include "support/scenes.h"

namespace plumbline {
namespace {

/// The desk from two poses some 2 cm and 1.5° apart, on three levels, and what the registration may look for.
class Problem {
 public:
  Problem(const Backend& backend, bool median_filter) {
    static const sim::AnalyticScene scene = sim::desk_corner();
    registration.world_from_model = sim::orbit().front().world_from_camera;
    truth = test::Random(5).motion(1.5 * kRadiansPerDegree, 0.02);
    for (int level = 2; level >= 0; --level) {
      const Pinhole camera = test::pinhole(160, 120).level(level);
      const auto seen = [&](const SE3& pose) {
        return test::to_level(backend, camera, test::view_of(scene, camera, pose));
      };
      images_.push_back({seen(registration.world_from_model * truth), seen(registration.world_from_model)});
      kernels::RegistrationLevel& out = registration.levels[registration.level_count++];
      out.images = icp_input(images_.back().live, images_.back().model);
      if (median_filter) out.distances = images_.back().live.pair_distances.view();
      out.pixels = camera.width * camera.height;
      out.iterations = 3;
      out.min_inliers = 6;
    }
    kernels::RegistrationRules& rules = registration.rules;
    rules.distance_gate = 0.1;
    rules.widest_gate = 0.3;
    rules.cos_normal_gate = static_cast<float>(std::cos(20 * kRadiansPerDegree));
    rules.bins = 500;
    rules.bins_per_metre = 1000;
    rules.median_filter = rules.every_distribution = median_filter;
    rules.median_band = 0.05;
    rules.max_condition = 1e6;
    rules.max_iterations = 10;
  }

  kernels::Registration registration;
  SE3 truth;  ///< model_from_live

 private:
  struct Images {
    DepthLevel live, model;
  };
  std::list<Images> images_;
};

struct Variant {
  const char* name;
  bool median_filter;
  std::function<void(kernels::Registration*)> change;
};

std::vector<Variant> variants() {
  return {
      {"plain", false, [](kernels::Registration*) {}},
      {"median filter", true, [](kernels::Registration*) {}},
      {"median stands still", true, [](kernels::Registration* r) { r->rules.converged_after = 2; }},
      {"small step", false, [](kernels::Registration* r) { r->rules.converged_step = 5e-4; }},
      {"gate follows the median", false,
       [](kernels::Registration* r) {
         r->rules.gate_per_median = 5;
         r->rules.every_distribution = true;
       }},
      {"anchor and position", false,
       [](kernels::Registration* r) {
         const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
         r->terms.set(kernels::OrientationAnchor{r->world_from_model.rotation(), unit, 20 * unit});
         r->terms.set(kernels::TranslationPrior{r->world_from_model.translation(), 20 * unit});
       }},
      {"tilt", false,
       [](kernels::Registration* r) {
         r->terms.set(kernels::TiltAnchor{r->world_from_model.rotation().row(2), Eigen::Matrix3d::Identity(),
                                          Eigen::Vector3d(20, 20, 0).asDiagonal()});
       }},
      {"pose", false,
       [](kernels::Registration* r) {
         r->terms.set(kernels::PosePrior{r->world_from_model, 20 * Matrix6d::Identity()});
       }},
      {"damping", false,
       [](kernels::Registration* r) {
         r->terms.set(kernels::RotationDamping{LambdaSchedule::inverse_sqrt, 0.05});
       }},
      {"nothing matches", false, [](kernels::Registration* r) { r->rules.distance_gate = 1e-9; }},
      {"no level", false, [](kernels::Registration* r) { r->level_count = 0; }},
  };
}

kernels::RegistrationState iterate(const Backend& backend, const Variant& variant) {
  Problem problem(backend, variant.median_filter);
  variant.change(&problem.registration);
  return backend.iterate(problem.registration, SE3());
}

class RegistrationTest : public test::LaneTest {};
PLUMBLINE_ON_EVERY_LANE_TYPE(RegistrationTest);

TEST_P(RegistrationTest, WithoutTheHostAsWithIt) {
  for (const Variant& variant : variants()) {
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
  for (const Variant& variant : variants()) {
    const kernels::RegistrationState once = iterate(backend(), variant), again = iterate(backend(), variant);
    EXPECT_EQ(once.model_from_live.rotation(), again.model_from_live.rotation()) << variant.name;
    EXPECT_EQ(once.model_from_live.translation(), again.model_from_live.translation()) << variant.name;
    EXPECT_EQ(std::memcmp(once.slots, again.slots, sizeof once.slots), 0) << variant.name;
  }
}

TEST_P(RegistrationTest, FindsTheMotionAsThePlainLaneDoes) {
  const std::shared_ptr<Backend> plain = test::make_lanes("scalar");
  for (const Variant& variant : variants()) {
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
