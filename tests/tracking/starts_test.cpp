// By what registrations are compared, and where else they may start.
#include "tracking/starts.h"

#include <gtest/gtest.h>

#include "plumbline/angles.h"
#include "plumbline/se3.h"
#include "support/scenes.h"
#include "tracking/orientation_guide.h"

namespace plumbline {
namespace {

TrackingResult registration(int with_depth, int pairs, int inliers) {
  TrackingResult result;
  result.status = TrackingStatus::tracked;
  result.pairs = pairs;
  result.inliers = inliers;
  result.inlier_fraction = static_cast<double>(inliers) / with_depth;
  return result;
}

TEST(Agreement, IsNotBoughtWithOverlap) {
  EXPECT_DOUBLE_EQ(agreement(registration(1000, 1000, 1000)), 1);
  EXPECT_DOUBLE_EQ(agreement(registration(1000, 500, 500)), 0.5);
  EXPECT_EQ(agreement(registration(1000, 0, 0)), 0);
  // A tenth of the image that fits is better than a third of which half contradicts.
  EXPECT_GT(agreement(registration(1000, 105, 100)), agreement(registration(1000, 330, 165)));
  EXPECT_LT(agreement(registration(1000, 1000, 300)), 0);
}

TEST(Agreement, IsDoubtfulWhereItFell) {
  const TrackingResult poor = registration(1000, 900, 540);
  ASSERT_NEAR(agreement(poor), 0, 1e-12);
  EXPECT_TRUE(is_doubtful(poor, 0.5));
  EXPECT_FALSE(is_doubtful(poor, 0.05)) << "a view that never matches well";
  EXPECT_FALSE(is_doubtful(registration(1000, 900, 700), 0.9)) << "good enough by itself";
  TrackingResult lost = registration(1000, 900, 900);
  lost.status = TrackingStatus::lost;
  EXPECT_TRUE(is_doubtful(lost, 0.05));
}

TEST(Starts, TurnAcrossTheLineOfSight) {
  const SE3 seed = test::Random(1).motion(1, 1);
  const std::vector<SE3> starts = turned_about(seed, 0.1);
  ASSERT_EQ(starts.size(), 24U);
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const Eigen::Vector3d turn = so3::log(seed.rotation().transpose() * starts[i].rotation());
    EXPECT_NEAR(turn.norm(), 0.1 * static_cast<double>(1 + i / 8), 1e-9);
    EXPECT_NEAR(turn.z(), 0, 1e-9);
    EXPECT_EQ(starts[i].translation(), seed.translation());
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_GT(so3::angle(starts[i].rotation().transpose() * starts[j].rotation()), 0.05);
  }
}

TEST(Starts, GoAsFarAsTheHeadingMayBeWrong) {
  const Eigen::Matrix3d earth_from_world = so3::exp({-1.4, 0.2, 0.9});
  const auto starts = [&](double turned, double heading_sigma, double search, bool has_heading = true) {
    OrientationParameters parameters = preset("kinectfusion").orientation;
    parameters.seed = OrientationSeed::relative;
    parameters.term = OrientationTerm::anchor;
    parameters.heading_sigma = heading_sigma;
    parameters.search = search;
    OrientationGuide guide(parameters, {.has_heading = has_heading});
    const SE3 first = test::Random(2).motion(1, 1);
    guide.observe(first, earth_from_world * first.rotation(), first.rotation());
    const Eigen::Matrix3d now = earth_from_world * first.rotation() * so3::exp({0, turned * kRadiansPerDegree, 0});
    const std::vector<SE3> list = guide.starts(guide.seed(first, now), now);
    for (const SE3& start : list) {
      EXPECT_EQ(start.translation(), first.translation());
      if (!has_heading) continue;
      // All of them have the sensor's tilt.
      EXPECT_LT(((earth_from_world * start.rotation()).row(2) - now.row(2)).norm(), 1e-9);
    }
    return list;
  };
  EXPECT_EQ(starts(5, 10, 4).size(), 1U) << "a small turn";
  EXPECT_EQ(starts(10, 10, 4).size(), 3U);
  EXPECT_EQ(starts(50, 10, 4).size(), 7U);
  EXPECT_EQ(starts(50, 2, 4).size(), 1U) << "a good sensor";
  EXPECT_EQ(starts(50, 10, 0).size(), 1U);
  EXPECT_EQ(starts(50, 10, 4, false).size(), 1U) << "tilt only";
  const std::vector<SE3> far = starts(50, 10, 4);
  EXPECT_NEAR(so3::angle(far.front().rotation().transpose() * far.back().rotation()), 12 * kRadiansPerDegree, 1e-9);
}

TEST(Starts, CoarseLeavesTheFinestLevelOutAndPatientGoesOn) {
  TrackingParameters parameters = preset("kinectfusion").tracking;
  parameters.iterations = {2, 2, 3};
  parameters.converged_step = 0.0005;
  EXPECT_EQ(coarse(parameters).iterations, (std::vector<int>{2, 2, 0}));
  EXPECT_EQ(pyramid_levels(coarse(parameters)), pyramid_levels(parameters));
  EXPECT_LT(patient(parameters).converged_step, parameters.converged_step);
  EXPECT_GT(patient(parameters).max_iterations, parameters.max_iterations);
  parameters.iterations = {3};
  EXPECT_EQ(coarse(parameters).iterations, parameters.iterations) << "there is no other level";
}

}  // namespace
}  // namespace plumbline
