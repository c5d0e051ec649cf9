#include "sensor/error_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/random.h"
#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/orientation.h"
#include "plumbline/se3.h"

namespace plumbline {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

TEST(SystematicError, IsPeriodicBoundedAndRepeats) {
  const SystematicError error({3 * kRadiansPerDegree, 3 * kRadiansPerDegree, 10 * kRadiansPerDegree}, 3, 7),
      other({3 * kRadiansPerDegree, 3 * kRadiansPerDegree, 10 * kRadiansPerDegree}, 3, 8);
  for (int axis = 0; axis < 3; ++axis) {
    const double amplitude = (axis == 2 ? 10 : 3) * kRadiansPerDegree;
    double largest = 0;
    for (int i = 0; i < 360; ++i) {
      const double angle = i * kRadiansPerDegree;
      largest = std::max(largest, std::abs(error.about(axis, angle)));
      EXPECT_NEAR(error.about(axis, angle), error.about(axis, angle + 2 * std::numbers::pi), 1e-12);
      // Turned about one axis, the sensor errs by that axis' function, as on the paper's rotary table.
      const Matrix3d r = so3::exp(angle * Vector3d::Unit(axis));
      EXPECT_NEAR(error.at(r)[axis], error.about(axis, angle), 1e-9);
    }
    EXPECT_NEAR(largest, amplitude, 0.01 * amplitude);
    EXPECT_NE(error.about(axis, 1), other.about(axis, 1));
  }
  // Smooth over all orientations: a millirad of turn changes it little, wherever it is.
  Random random(3);
  for (int i = 0; i < 2000; ++i) {
    const Matrix3d r = so3::exp(3.1 * Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)));
    const Matrix3d turned_a_little = so3::exp(Vector3d(5e-4, -6e-4, 6e-4)) * r;
    EXPECT_LT((error.at(r) - error.at(turned_a_little)).norm(), 0.012);
  }
}

TEST(SystematicError, RefusesValuesOutOfRange) {
  EXPECT_THROW(SystematicError({-1, 0, 0}, 3, 1), Error);
  EXPECT_THROW(SystematicError({0, std::nan(""), 0}, 3, 1), Error);
  EXPECT_THROW(SystematicError({0, 0, 0}, 0, 1), Error);
}

/// A turn about the vertical in steps of half a degree.
std::vector<OrientationSample> turntable() {
  std::vector<OrientationSample> samples;
  for (int i = 0; i < 720; ++i)
    samples.push_back({i * 10'000'000LL, so3::exp(Vector3d(0, 0, 0.5 * i * kRadiansPerDegree))});
  return samples;
}

TEST(ErrorModel, Bno055ReachesItsAmplitudesInEarthAxes) {
  const auto exact = turntable();
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    OrientationErrorModel model = error_model("bno055");
    model.seed = seed;
    const auto erring = with_error(model, exact);
    ASSERT_EQ(erring.size(), exact.size());
    const SystematicError error(model.amplitude, model.harmonics, seed);
    double heading = 0;
    for (std::size_t i = 0; i < exact.size(); ++i) {
      EXPECT_EQ(erring[i].time, exact[i].time);
      const Vector3d e = so3::log(erring[i].earth_from_body * exact[i].earth_from_body.transpose());
      EXPECT_LT((e - error.at(exact[i].earth_from_body)).norm(), 1e-9);
      heading = std::max(heading, std::abs(e.z()));
      EXPECT_LE(e.head<2>().cwiseAbs().maxCoeff(), 3.001 * kRadiansPerDegree);
    }
    EXPECT_NEAR(heading, 10 * kRadiansPerDegree, 0.01 * kRadiansPerDegree) << seed;
  }
}

TEST(ErrorModel, RepeatsWithTheSeedAndTheOrientation) {
  const auto exact = turntable();
  const OrientationErrorModel model = error_model("bno055");
  OrientationErrorModel other = model;
  other.seed = 2;
  const auto a = with_error(model, exact), b = with_error(model, exact), c = with_error(other, exact);
  double difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].earth_from_body, b[i].earth_from_body);
    difference = std::max(difference, so3::angle(a[i].earth_from_body.transpose() * c[i].earth_from_body));
  }
  EXPECT_GT(difference, 3 * kRadiansPerDegree);
  // The same orientation later has the same error.
  const auto twice = with_error(model, {exact[100], {exact[100].time + 1, exact[100].earth_from_body}});
  EXPECT_EQ(twice[0].earth_from_body, twice[1].earth_from_body);
}

TEST(ErrorModel, IdealChangesNothingAndOthersAreUnknown) {
  const auto exact = turntable(), same = with_error(error_model("ideal"), exact);
  for (std::size_t i = 0; i < exact.size(); ++i) EXPECT_EQ(same[i].earth_from_body, exact[i].earth_from_body);
  EXPECT_THROW(error_model("bno05"), Error);
}

}  // namespace
}  // namespace plumbline
