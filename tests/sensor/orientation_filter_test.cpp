// The filters against motions whose orientation is known, and on the BROAD benchmark.
#include "sensor/orientation_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/random.h"
#include "eval/orientation_error.h"
#include "io/imu_file.h"
#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/orientation.h"
#include "plumbline/se3.h"
#include "sensor/low_pass.h"
#include "sensor/madgwick.h"
#include "support/data.h"

namespace plumbline {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kRate = 200;
const Vector3d kGravity(0, 0, 9.81), kField(0, 20, -44);

/// A hand that turns to and fro about all axes.
Matrix3d hand(double t) {
  return so3::exp({0.5 * std::sin(1.3 * t), 0.6 * std::sin(0.9 * t), 0.4 * std::sin(1.7 * t)});
}

struct Truth {
  ImuRecording recording;
  std::vector<OrientationSample> orientation;
};

/// Exact readings of a motion, and a bias of the gyroscope. `field`: at a time, earth axes.
template <class Motion, class Field>
Truth measured(const Motion& motion, double seconds, const Vector3d& bias, const Field& field) {
  Truth truth;
  truth.recording.has_gyroscope = truth.recording.has_magnetometer = true;
  for (int i = 0; i < seconds * kRate; ++i) {
    const double t = i / kRate;
    const Matrix3d r = motion(t), before = motion(t - 1 / kRate);
    ImuSample reading;
    reading.time = from_seconds(t);
    reading.angular_rate = kRate * so3::log(before.transpose() * r) + bias;
    reading.specific_force = r.transpose() * kGravity;
    reading.magnetic_field = r.transpose() * field(t);
    truth.recording.samples.push_back(reading);
    truth.orientation.push_back({reading.time, r});
  }
  return truth;
}

Vector3d undisturbed(double /*t*/) { return kField; }

/// Of the part after `from` seconds.
eval::OrientationError error_after(double from, const Truth& truth, const std::vector<OrientationSample>& estimate) {
  std::vector<OrientationSample> late;
  for (const OrientationSample& s : truth.orientation)
    if (s.time > from_seconds(from)) late.push_back(s);
  return eval::orientation_error(late, estimate);
}

// ---- low-pass -------------------------------------------------------------------------------------------------------

TEST(LowPass, HalvesThePowerAtItsCutOff) {
  const double tau = 0.2, cutoff = std::numbers::sqrt2 / (2 * std::numbers::pi * tau);
  LowPass<1> filter(tau, 1e-3);
  double largest = 0;
  for (int i = 0; i < 20000; ++i) {
    const double x = std::sin(2 * std::numbers::pi * cutoff * i * 1e-3);
    const double y = filter.update(Eigen::Matrix<double, 1, 1>(x))[0];
    if (i > 10000) largest = std::max(largest, std::abs(y));
  }
  EXPECT_NEAR(largest, 1 / std::numbers::sqrt2, 2e-3);
}

TEST(LowPass, BothWaysHasNoDelay) {
  std::vector<Eigen::Matrix<double, 1, 1>> bump(4001);
  for (int i = 0; i <= 4000; ++i) bump[static_cast<std::size_t>(i)][0] = std::exp(-std::pow((i - 2000) / 300.0, 2));
  const auto smooth = low_pass_both_ways<1>(bump, 0.1, 1e-3);
  for (std::size_t i = 1; i < 2000; ++i) EXPECT_NEAR(smooth[2000 - i][0], smooth[2000 + i][0], 1e-4);
  EXPECT_LT(smooth[2000][0], 0.999);
  EXPECT_GT(smooth[2000][0], 0.9);
}

// ---- filters --------------------------------------------------------------------------------------------------------

TEST(OrientationFilter, FollowsAHandInSpiteOfABias) {
  const Truth truth = measured(hand, 60, Vector3d(0.4, -0.3, 0.2) * kRadiansPerDegree, undisturbed);
  const auto forward = error_after(30, truth, filter_orientation(truth.recording));
  EXPECT_LT(forward.inclination, 0.3 * kRadiansPerDegree);
  EXPECT_LT(forward.heading, 2.5 * kRadiansPerDegree);
  const auto offline = error_after(0, truth, smooth_orientation(truth.recording));
  EXPECT_LT(offline.inclination, 0.3 * kRadiansPerDegree);
  EXPECT_LT(offline.heading, 2.0 * kRadiansPerDegree);
}

TEST(OrientationFilter, AtRestTheBiasIsFoundAndTheHeadingStays) {
  const auto still = [](double) { return so3::exp({0.3, -0.2, 1}); };
  Truth truth = measured(still, 60, Vector3d(0.5, 0.5, 0.8) * kRadiansPerDegree, undisturbed);
  for (ImuSample& r : truth.recording.samples) r.magnetic_field.reset();
  truth.recording.has_magnetometer = false;
  const auto samples = filter_orientation(truth.recording);
  const Matrix3d drift = samples.back().earth_from_body * samples[samples.size() / 2].earth_from_body.transpose();
  EXPECT_LT(so3::angle(drift), 0.5 * kRadiansPerDegree) << "unestimated, 0.8 degrees a second are 24 degrees";
}

TEST(OrientationFilter, IgnoresAMagnet) {
  const auto field = [](double t) { return Vector3d(t > 30 && t < 45 ? Vector3d(40, 20, -20) : kField); };
  const Truth truth = measured(hand, 60, Vector3d::Zero(), field);
  EXPECT_LT(error_after(20, truth, filter_orientation(truth.recording)).heading, 1 * kRadiansPerDegree);
  EXPECT_LT(error_after(20, truth, smooth_orientation(truth.recording)).heading, 1 * kRadiansPerDegree);
  EXPECT_GT(error_after(20, truth, madgwick_orientation(truth.recording)).heading, 10 * kRadiansPerDegree)
      << "the disturbance is too weak to show anything";
}

TEST(OrientationFilter, WithoutAGyroscopeOrReadingsSaysSo) {
  ImuRecording recording;
  recording.has_gyroscope = true;
  EXPECT_THROW(filter_orientation(recording), Error);
  recording.samples.resize(10);
  for (int i = 0; i < 10; ++i) recording.samples[static_cast<std::size_t>(i)].time = i * 1000000;
  recording.has_gyroscope = false;
  EXPECT_THROW(filter_orientation(recording), Error);
  EXPECT_THROW(smooth_orientation(recording), Error);
  EXPECT_THROW(madgwick_orientation(recording), Error);
  OrientationFilterOptions bad;
  bad.tau_accelerometer = 0;
  recording.has_gyroscope = true;
  EXPECT_THROW(filter_orientation(recording, bad), Error);
}

TEST(Tilt, IsThatOfTheAccelerationAndTurnsAboutHorizontalAxes) {
  Truth truth = measured(hand, 10, Vector3d::Zero(), undisturbed);
  truth.recording.has_gyroscope = false;
  for (const bool both_ways : {false, true}) {
    const auto samples = tilt_from_accelerometer(truth.recording, 0.02, both_ways);
    EXPECT_LT(error_after(1, truth, samples).inclination, (both_ways ? 0.1 : 1.5) * kRadiansPerDegree);
    for (std::size_t i = 1; i < samples.size(); ++i) {
      const Vector3d turn = so3::log(samples[i].earth_from_body * samples[i - 1].earth_from_body.transpose());
      EXPECT_LT(std::abs(turn.z()), 1e-9);
    }
  }
}

TEST(Madgwick, FindsTheOrientationFromAWrongStart) {
  const auto still = [](double) { return so3::exp({0.3, -0.2, 1}); };
  Truth truth = measured(still, 20, Vector3d::Zero(), undisturbed);
  truth.recording.samples.front().magnetic_field = Vector3d(30, 0, -20);
  truth.recording.samples.front().specific_force = Vector3d(5, 2, 8);
  const auto error = error_after(15, truth, madgwick_orientation(truth.recording));
  EXPECT_LT(error.total, 0.2 * kRadiansPerDegree);
}

// ---- BROAD ----------------------------------------------------------------------------------------------------------

struct Trial {
  eval::OrientationError ours, offline, madgwick;
};

Trial run_trial(const std::filesystem::path& path) {
  const ImuRecording recording = read_imu(path.string());
  const auto error = [&](const std::vector<OrientationSample>& samples) {
    return eval::orientation_error(recording.reference, samples);
  };
  return {error(filter_orientation(recording)), error(smooth_orientation(recording)),
          error(madgwick_orientation(recording))};
}

// docs/results.md has the figures; the bounds leave a fifth.
TEST(Broad, UndisturbedTrials) {
  PLUMBLINE_DATA_OR_SKIP(folder, "imu/broad");
  const Trial slow = run_trial(folder / "03_undisturbed_slow_rotation_C.csv.gz"),
              fast = run_trial(folder / "07_undisturbed_fast_rotation_B.csv.gz");
  EXPECT_LT(slow.ours.total, 2.4 * kRadiansPerDegree);
  EXPECT_LT(slow.ours.inclination, 0.5 * kRadiansPerDegree);
  EXPECT_LT(slow.offline.total, 1.7 * kRadiansPerDegree);
  EXPECT_LT(fast.ours.total, 2.0 * kRadiansPerDegree);
  EXPECT_LT(fast.ours.inclination, 1.2 * kRadiansPerDegree);
  EXPECT_LT(slow.ours.total + fast.ours.total, 0.59 * (slow.madgwick.total + fast.madgwick.total));
  EXPECT_LT(slow.ours.inclination + fast.ours.inclination,
            0.5 * (slow.madgwick.inclination + fast.madgwick.inclination));
}

TEST(Broad, MagnetTrial) {
  PLUMBLINE_DATA_OR_SKIP(path, "imu/broad/31_disturbed_stationary_magnet_D.csv.gz");
  const Trial trial = run_trial(path);
  EXPECT_LT(trial.ours.total, 3.9 * kRadiansPerDegree);
  EXPECT_LT(trial.ours.inclination, 0.5 * trial.madgwick.inclination);
  EXPECT_LT(trial.ours.total, 0.7 * trial.madgwick.total);
}

}  // namespace
}  // namespace plumbline
