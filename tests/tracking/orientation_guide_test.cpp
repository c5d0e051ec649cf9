// Seeds and trust: what the sensor contributes, and when it does not.
#include "tracking/orientation_guide.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/se3.h"
#include "sensor/error_model.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

OrientationParameters parameters(OrientationSeed seed, OrientationTerm term = OrientationTerm::none) {
  OrientationParameters p = preset("kinectfusion").orientation;
  p.seed = seed;
  p.term = term;
  return p;
}

void expect_same(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) { EXPECT_LT(so3::angle(a.transpose() * b), 1e-9); }

TEST(OrientationGuide, AbsoluteSeedIsTheReadingInTheWorld) {
  OrientationGuide guide(parameters(OrientationSeed::absolute));
  test::Random random(1);
  const Eigen::Matrix3d earth_from_world = random.motion(2, 0).rotation();
  const SE3 first = random.motion(1, 1), second = random.motion(1, 1);
  EXPECT_EQ(guide.use(earth_from_world * first.rotation()), OrientationUse::first);
  guide.observe(first, earth_from_world * first.rotation(), first.rotation());
  EXPECT_EQ(guide.use(earth_from_world * second.rotation()), OrientationUse::used);
  const SE3 seed = guide.seed(first, earth_from_world * second.rotation());
  expect_same(seed.rotation(), second.rotation());
  EXPECT_EQ(seed.translation(), first.translation()) << "nothing about the position comes from the sensor";
}

TEST(OrientationGuide, RelativeSeedForgivesAConstantError) {
  OrientationGuide guide(parameters(OrientationSeed::relative));
  const SE3 first = test::Random(2).motion(1, 1), second = test::Random(3).motion(1, 1);
  const Eigen::Matrix3d error = so3::exp({0.1, -0.05, 0.2});
  guide.observe(first, first.rotation(), first.rotation());
  // The tracker went elsewhere than the sensor: the next seed starts from there.
  const SE3 tracked(error * second.rotation(), second.translation());
  guide.observe(tracked, second.rotation(), tracked.rotation());
  const SE3 third = test::Random(4).motion(1, 1);
  expect_same(guide.seed(tracked, third.rotation()).rotation(),
              error * second.rotation() * second.rotation().transpose() * third.rotation());
}

TEST(OrientationGuide, WithoutAReadingThereIsNoRelativeSeed) {
  OrientationGuide guide(parameters(OrientationSeed::relative));
  const SE3 first, second = test::Random(5).motion(0.1, 0.1);
  guide.observe(first, first.rotation(), first.rotation());
  EXPECT_EQ(guide.use(std::nullopt), OrientationUse::missing);
  guide.observe(second, std::nullopt, second.rotation());
  expect_same(guide.seed(second, test::Random(6).motion(1, 0).rotation()).rotation(), second.rotation());
}

TEST(OrientationGuide, NothingIsUsedUnlessAskedFor) {
  OrientationGuide guide(parameters(OrientationSeed::none));
  EXPECT_FALSE(guide.is_on());
  EXPECT_EQ(guide.use(Eigen::Matrix3d(Eigen::Matrix3d::Identity())), OrientationUse::off);
  kernels::Terms terms;
  guide.add_term(Eigen::Matrix3d::Identity(), &terms);
  EXPECT_TRUE(terms.empty());
  EXPECT_TRUE(OrientationGuide(parameters(OrientationSeed::none, OrientationTerm::damping)).is_on());
}

// ---- trust ----------------------------------------------------------------------------------------------------------

/// A hand that turns to and fro about all axes, up to a degree a frame.
Eigen::Matrix3d hand(int frame) {
  const double t = frame / 30.0;
  return so3::exp({0.3 * std::sin(1.3 * t), 0.4 * std::sin(0.9 * t + 1), 0.2 * std::sin(1.7 * t + 2)});
}

/// Frames out of 300 in which the sensor was trusted.
template <class Reading>
int trusted_frames(const Reading& reading) {
  OrientationMonitor monitor(preset("kinectfusion").orientation.distrust);
  int trusted = 0;
  for (int i = 0; i < 300; ++i) {
    monitor.observe(reading(i), hand(i));
    trusted += monitor.trusted();
  }
  return trusted;
}

TEST(OrientationMonitor, TrustsASensor) {
  EXPECT_EQ(trusted_frames([](int i) { return hand(i); }), 300);
  const Eigen::Matrix3d earth_from_world = test::Random(7).motion(2, 0).rotation();
  EXPECT_EQ(trusted_frames([&](int i) { return Eigen::Matrix3d(earth_from_world * hand(i)); }), 300);
}

TEST(OrientationMonitor, TrustsAChipWithItsSystematicError) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const SystematicError error(error_model("bno055").amplitude, 3, seed);
    EXPECT_EQ(trusted_frames([&](int i) { return Eigen::Matrix3d(so3::exp(error.at(hand(i))) * hand(i)); }), 300)
        << seed;
  }
}

TEST(OrientationMonitor, DistrustsGarbage) {
  const Eigen::Matrix3d half_turn = so3::exp({0, 0, std::numbers::pi});
  Eigen::Matrix3d swapped;
  swapped << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  EXPECT_LT(trusted_frames([](int) { return Eigen::Matrix3d(Eigen::Matrix3d::Identity()); }), 60) << "constant";
  EXPECT_LT(trusted_frames([](int i) { return Eigen::Matrix3d(hand(i).transpose()); }), 60) << "inverse";
  EXPECT_LT(trusted_frames([&](int i) { return Eigen::Matrix3d(hand(i) * half_turn); }), 60) << "mounting";
  EXPECT_LT(trusted_frames([&](int i) { return Eigen::Matrix3d(hand(i) * swapped); }), 60) << "axes";
  EXPECT_LT(trusted_frames([](int i) { return hand(i + 60); }), 60) << "two seconds late";
}

TEST(OrientationMonitor, TrustComesBack) {
  OrientationMonitor monitor(preset("kinectfusion").orientation.distrust);
  for (int i = 0; i < 100; ++i) monitor.observe(hand(i), hand(i));
  EXPECT_TRUE(monitor.trusted());
  for (int i = 100; i < 160; ++i) monitor.observe(hand(100), hand(i));
  EXPECT_FALSE(monitor.trusted()) << "the sensor hangs";
  for (int i = 160; i < 300; ++i) monitor.observe(hand(i), hand(i));
  EXPECT_TRUE(monitor.trusted());
}

TEST(OrientationMonitor, ADistrustOfZeroAlwaysTrusts) {
  OrientationMonitor monitor(0);
  for (int i = 0; i < 100; ++i) monitor.observe(hand(i).transpose(), hand(i));
  EXPECT_TRUE(monitor.trusted());
}

// ---- a sensor without heading ---------------------------------------------------------------------------------------

constexpr bool kTiltOnly = false, kWithHeading = true;

/// A guide by a sensor with or without heading.
OrientationGuide guide_by(bool has_heading) {
  return OrientationGuide(parameters(OrientationSeed::relative, OrientationTerm::anchor), {.has_heading = has_heading});
}

/// Frames out of 300 in which a guide used the readings.
template <class Reading>
int used_frames(OrientationGuide guide, const Reading& reading) {
  const Eigen::Matrix3d earth_from_world = so3::exp({1.4, 0.3, 0.2});
  int used = 0;
  for (int i = 0; i < 300; ++i) {
    const Eigen::Matrix3d read = reading(i, earth_from_world * hand(i));
    const OrientationUse use = guide.use(read);
    used += use == OrientationUse::used || use == OrientationUse::first;
    guide.observe(SE3(hand(i), Eigen::Vector3d::Zero()), read, hand(i));
  }
  return used;
}

/// Information of the anchor of a sensor with `covariance`, radians².
Matrix6d anchor_of(const std::optional<Eigen::Matrix3d>& covariance) {
  OrientationGuide guide(parameters(OrientationSeed::relative, OrientationTerm::anchor), {.covariance = covariance});
  guide.observe(SE3(), Eigen::Matrix3d(Eigen::Matrix3d::Identity()), Eigen::Matrix3d(Eigen::Matrix3d::Identity()));
  kernels::Terms terms;
  guide.add_term(Eigen::Matrix3d::Identity(), &terms);
  return terms.evaluate({SE3()}).h;
}

TEST(OrientationSensor, ItsCovarianceReplacesTheSigmas) {
  const Eigen::Matrix3d covariance = Eigen::Vector3d(0.01, 0.02, 0.04).asDiagonal();
  EXPECT_NEAR(anchor_of(covariance)(0, 0), 100, 1e-9);
  EXPECT_NEAR(anchor_of(covariance)(2, 2), 25, 1e-9);
  const OrientationParameters sigmas;
  EXPECT_NEAR(anchor_of(std::nullopt)(2, 2) * std::pow(sigmas.heading_sigma.radians(), 2), 1, 1e-9);
}

TEST(OrientationSensor, ACovarianceIsSymmetricAndPositiveDefinite) {
  Eigen::Matrix3d skewed = Eigen::Matrix3d::Identity();
  skewed(0, 1) = 0.5;
  EXPECT_THROW(anchor_of(skewed), Error);
  EXPECT_THROW(anchor_of(Eigen::Matrix3d(Eigen::Vector3d(1, 1, -1).asDiagonal())), Error);
}

TEST(TiltOnly, AnyHeadingIsAsGood) {
  const auto any_heading = [](int i, const Eigen::Matrix3d& truth) {
    return Eigen::Matrix3d(so3::exp({0, 0, 0.3 * i}) * truth);
  };
  EXPECT_EQ(used_frames(guide_by(kTiltOnly), any_heading), 300);
  EXPECT_LT(used_frames(guide_by(kWithHeading), any_heading), 100);
}

TEST(TiltOnly, AWrongTiltIsDistrusted) {
  const auto inverse = [](int /*i*/, const Eigen::Matrix3d& truth) { return Eigen::Matrix3d(truth.transpose()); };
  EXPECT_LT(used_frames(guide_by(kTiltOnly), inverse), 100);
}

TEST(TiltOnly, TheSeedIsTheCallersAndTheTermHoldsTheTilt) {
  OrientationGuide guide = guide_by(kTiltOnly);
  guide.observe(SE3(), Eigen::Matrix3d::Identity(), Eigen::Matrix3d(Eigen::Matrix3d::Identity()));
  const SE3 last = test::Random(8).motion(0.3, 0.3);
  const Eigen::Matrix3d reading = so3::exp({0.1, 0, 0.7});
  expect_same(guide.seed(last, reading).rotation(), last.rotation());
  kernels::Terms terms;
  guide.add_term(reading, &terms);
  const kernels::NormalEquations term = terms.evaluate({SE3()});
  EXPECT_GT(term.b.norm(), 0);
  EXPECT_NEAR(term.b[2], 0, 1e-9);
}

}  // namespace
}  // namespace plumbline
