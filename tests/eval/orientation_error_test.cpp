#include "eval/orientation_error.h"

#include <gtest/gtest.h>

#include "plumbline/error.h"
#include "plumbline/se3.h"

namespace plumbline::eval {
namespace {

TEST(OrientationError, PartsOfARotation) {
  const Eigen::Matrix3d truth = so3::exp({0.5, -1, 2});
  const auto error = [&](const Eigen::Vector3d& e) {
    return orientation_error({{10, truth}}, {{10, so3::exp(e) * truth}});
  };
  const OrientationError heading = error({0, 0, -0.3}), tilt = error({0.12, -0.16, 0});
  EXPECT_NEAR(heading.total, 0.3, 1e-12);
  EXPECT_NEAR(heading.heading, 0.3, 1e-12);
  EXPECT_NEAR(heading.inclination, 0, 1e-9);
  EXPECT_NEAR(tilt.total, 0.2, 1e-12);
  EXPECT_NEAR(tilt.heading, 0, 1e-9);
  EXPECT_NEAR(tilt.inclination, 0.2, 1e-12);
  // A tilt after a turn about the vertical: both come back.
  const OrientationError both =
      orientation_error({{10, truth}}, {{10, so3::exp({0.2, 0, 0}) * so3::exp({0, 0, 0.3}) * truth}});
  EXPECT_NEAR(both.heading, 0.3, 1e-12);
  EXPECT_NEAR(both.inclination, 0.2, 1e-12);
}

TEST(OrientationError, RootMeanSquareOverThePairsThatAgree) {
  const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
  const OrientationError error =
      orientation_error({{0, one}, {10'000'000, one}, {20'000'000, one}},
                        {{100, so3::exp({0.3, 0, 0})}, {10'000'000, so3::exp({0.4, 0, 0})}, {15'000'000, one}});
  EXPECT_EQ(error.count, 2U);
  EXPECT_NEAR(error.total, std::sqrt((0.09 + 0.16) / 2), 1e-12);
  EXPECT_THROW(orientation_error({{0, one}}, {{1'000'000'000, one}}), Error);
}

}  // namespace
}  // namespace plumbline::eval
