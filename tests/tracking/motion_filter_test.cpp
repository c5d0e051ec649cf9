// The filter against a motion that is known in closed form.
#include "tracking/motion_filter.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <random>

#include "plumbline/angles.h"

namespace plumbline {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const Vector3d kGravity(0, 0, -9.81);  // world
constexpr double kFrame = 1.0 / 30, kReading = 0.01;

/// A hand that turns about all axes and moves to and fro: pose, its rate and its specific force at t seconds.
struct Hand {
  Vector3d angles(double t) const {
    return {0.5 * std::sin(2 * t), 0.4 * std::sin(3.1 * t + 1), 0.3 * std::sin(4 * t)};
  }
  SE3 pose(double t) const {
    return {so3::exp(angles(t)), Vector3d(0.3 * std::sin(2.2 * t), 0.2 * std::cos(1.7 * t), 0.1 * std::sin(3 * t))};
  }
  Vector3d rate(double t) const {
    constexpr double h = 1e-4;
    return so3::log(Matrix3d(pose(t - h).rotation().transpose() * pose(t + h).rotation())) / (2 * h);
  }
  Vector3d force(double t) const {
    constexpr double h = 1e-3;
    const Vector3d acceleration =
        (pose(t + h).translation() - 2 * pose(t).translation() + pose(t - h).translation()) / (h * h);
    return pose(t).rotation().transpose() * (acceleration - kGravity);
  }
};

struct Errors {
  Vector3d gyroscope_bias = Vector3d::Zero(), accelerometer_bias = Vector3d::Zero();
  double late = 0;  ///< seconds by which the sensor's stamps are late
};

Nanoseconds stamp(double seconds) { return from_seconds(100 + seconds); }

std::vector<ImuSample> readings(const Hand& hand, double from, double to, const Errors& errors = {},
                                double step = kReading) {
  std::vector<ImuSample> samples;
  for (double stamped = std::ceil(from / step) * step; stamped <= to; stamped += step) {
    const double t = stamped - errors.late;
    samples.push_back({.time = stamp(stamped),
                       .angular_rate = hand.rate(t) + errors.gyroscope_bias,
                       .specific_force = hand.force(t) + errors.accelerometer_bias});
  }
  return samples;
}

/// The pose that a registration finds whose images see `seen` with that covariance, and its own covariance.
void register_and_correct(const SE3& seen, const Matrix6d& covariance, MotionFilter* filter) {
  const Matrix6d predicted = filter->pose_covariance(), gain = predicted * (predicted + covariance).inverse();
  const SE3& expected = filter->world_from_camera();
  const Vector6d step = gain * pose_difference(seen, expected);
  const SE3 pose(Matrix3d(so3::exp(Vector3d(step.head<3>())) * expected.rotation()),
                 Vector3d(expected.translation() + step.tail<3>()));
  filter->correct(pose, (Matrix6d::Identity() - gain) * predicted);
}

/// Corrected by true poses, `frames` of them; with `random` readings and poses have the noise that the filter expects.
MotionFilter followed(const Hand& hand, const Errors& errors, int frames, std::mt19937* random = nullptr) {
  constexpr double kPoseSigma = 1e-3;
  std::normal_distribution<double> normal;
  const auto noise = [&](double sigma) -> Vector3d {
    if (random == nullptr) return Vector3d::Zero();
    return {sigma * normal(*random), sigma * normal(*random), sigma * normal(*random)};
  };
  std::vector<ImuSample> all = readings(hand, -0.2, frames * kFrame + 1, errors);
  for (ImuSample& sample : all) {
    sample.angular_rate += noise(0.003 / std::sqrt(kReading));
    sample.specific_force += noise(0.05 / std::sqrt(kReading));
  }
  MotionFilter filter;
  filter.start(hand.pose(0), stamp(0), all);
  for (int i = 1; i <= frames; ++i) {
    const SE3 truth = hand.pose(i * kFrame);
    filter.propagate(all, stamp(i * kFrame));
    const SE3 seen(Matrix3d(so3::exp(noise(kPoseSigma)) * truth.rotation()),
                   Vector3d(truth.translation() + noise(kPoseSigma)));
    register_and_correct(seen, Vector6d::Constant(kPoseSigma * kPoseSigma).asDiagonal(), &filter);
  }
  filter.propagate(all, stamp((frames + 1) * kFrame));
  return filter;
}

double rotation_error(const SE3& a, const SE3& b) { return so3::angle(a.rotation().transpose() * b.rotation()); }

TEST(MotionFilter, TurnsAndMovesAsTheReadingsSay) {
  const Hand hand;
  MotionFilter filter = followed(hand, {}, 300);
  const double start = 301 * kFrame, end = start + 0.5;
  filter.propagate(readings(hand, start - 0.2, end + 0.2), stamp(end));
  EXPECT_LT(rotation_error(filter.world_from_camera(), hand.pose(end)), radians(0.1));
  EXPECT_LT((filter.world_from_camera().translation() - hand.pose(end).translation()).norm(), 0.02);
  EXPECT_TRUE(filter.is_inertial());
}

TEST(MotionFilter, LearnsBiasesAndGravity) {
  const Errors errors{.gyroscope_bias = {0.01, -0.006, 0.004}, .accelerometer_bias = {0.05, 0.02, -0.04}};
  const MotionFilter filter = followed(Hand(), errors, 600);
  EXPECT_LT((filter.gyroscope_bias() - errors.gyroscope_bias).norm(), 1e-3);
  EXPECT_LT((filter.accelerometer_bias() - errors.accelerometer_bias).norm(), 0.03);
  EXPECT_LT((filter.gravity() - kGravity).norm(), 0.03);
}

TEST(MotionFilter, FindsTheSensorsClock) {
  for (const double late : {-0.1, -0.02, 0.0, 0.03, 0.1}) {
    const MotionFilter filter = followed(Hand(), {.late = late}, 300);
    EXPECT_NEAR(filter.lateness(), late, 0.003) << late << " s late, after ten seconds";
  }
}

TEST(MotionFilter, GoesOnSteadilyWithoutReadings) {
  MotionFilter filter;
  const Vector3d velocity(0.3, -0.1, 0.2), rate(0.2, 0.5, -0.4);
  const auto pose = [&](double t) { return SE3(so3::exp(Vector3d(t * rate)), Vector3d(t * velocity)); };
  filter.start(pose(0), stamp(0), {});
  for (int i = 1; i <= 30; ++i) {
    filter.propagate({}, stamp(i * kFrame));
    filter.correct(pose(i * kFrame), Vector6d::Constant(1e-8).asDiagonal());
  }
  const Matrix6d before = filter.pose_covariance();
  filter.propagate({}, stamp(31 * kFrame));
  EXPECT_FALSE(filter.is_inertial());
  EXPECT_LT(rotation_error(filter.world_from_camera(), pose(31 * kFrame)), 1e-6);
  EXPECT_LT((filter.world_from_camera().translation() - pose(31 * kFrame).translation()).norm(), 1e-3);
  EXPECT_GT(filter.pose_covariance().trace(), 10 * before.trace()) << "ever less surely";
}

TEST(MotionFilter, ReadingsWithAGapAreBridged) {
  const Hand hand;
  std::vector<ImuSample> some = readings(hand, -0.1, 1.2);
  std::erase_if(some, [](const ImuSample& s) { return s.time > stamp(0.2) && s.time < stamp(0.7); });
  MotionFilter filter;
  filter.start(hand.pose(0), stamp(0), some);
  const Matrix6d before = filter.pose_covariance();
  filter.propagate(some, stamp(1));
  EXPECT_TRUE(filter.world_from_camera().is_finite());
  EXPECT_GT(filter.pose_covariance()(0, 0), before(0, 0) + 0.3 * 0.3 * 0.4) << "half a second was guessed";
}

TEST(MotionFilter, ItsCovarianceIsThatOfItsErrors) {
  // The normalised squared error of six directions is six.
  const Hand hand;
  constexpr int kRuns = 60, kFrames = 90;
  double sum = 0;
  for (unsigned seed = 0; seed < kRuns; ++seed) {
    std::mt19937 random(seed);
    const MotionFilter filter = followed(hand, {}, kFrames, &random);
    const Vector6d error = pose_difference(hand.pose((kFrames + 1) * kFrame), filter.world_from_camera());
    sum += error.dot(filter.pose_covariance().inverse() * error);
  }
  EXPECT_GT(sum / kRuns, 3);
  EXPECT_LT(sum / kRuns, 9);
}

TEST(MotionFilter, ItsCovarianceStaysPositive) {
  const MotionFilter filter = followed(Hand(), {.gyroscope_bias = {0.02, 0, 0}, .late = 0.05}, 900);
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(filter.pose_covariance());
  EXPECT_GT(solver.eigenvalues().minCoeff(), 0);
}

TEST(MotionFilter, ReadingsThatAreNoNumbersAreLeftOut) {
  const Hand hand;
  std::vector<ImuSample> some = readings(hand, -0.1, 0.4);
  MotionFilter filter;
  filter.start(hand.pose(0), stamp(0), {});
  some[5].angular_rate.x() = std::numeric_limits<double>::quiet_NaN();
  some[9].specific_force.y() = std::numeric_limits<double>::infinity();
  filter.propagate(some, stamp(0.3));
  EXPECT_TRUE(filter.world_from_camera().is_finite());
}

}  // namespace
}  // namespace plumbline
