#include "plumbline/orientation_stream.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/orientation.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"

namespace plumbline {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr Nanoseconds kMs = 1'000'000, kStart = 1'305'031'102'000'000'000;

const Vector3d kRate(0.4, -1.1, 0.7);  // rad/s, body axes
const Matrix3d kFirst = so3::exp(Vector3d(2, 0.3, -1));

Matrix3d at(Nanoseconds time) { return kFirst * so3::exp(to_seconds(time - kStart) * kRate); }

/// Every 10 ms at a constant rate, over 1 s from kStart, without those from `gap_begin` to `gap_end` (ms, exclusive).
std::vector<OrientationSample> samples(int gap_begin = 0, int gap_end = 0) {
  std::vector<OrientationSample> out;
  for (int i = 0; i <= 100; ++i)
    if (10 * i <= gap_begin || 10 * i >= gap_end) out.push_back({kStart + 10 * i * kMs, at(kStart + 10 * i * kMs)});
  return out;
}

void expect_near(const OrientationReading& reading, const Matrix3d& expected, double angle) {
  ASSERT_EQ(reading.status, OrientationStatus::ok);
  EXPECT_LT(so3::angle(reading.earth_from_body.transpose() * expected), angle);
}

TEST(OrientationStream, IsExactAtAConstantRate) {
  const OrientationStream stream(samples(), {});
  for (Nanoseconds t = kStart; t <= kStart + 1000 * kMs; t += 1'234'567) expect_near(stream.lookup(t), at(t), 1e-7);
  EXPECT_EQ(stream.lookup(kStart + 500 * kMs).earth_from_body, samples()[50].earth_from_body);
}

TEST(OrientationStream, BoundsItsExtrapolation) {
  const OrientationStream stream(samples(), {});
  const Nanoseconds end = kStart + 1000 * kMs;
  expect_near(stream.lookup(end + 20 * kMs), at(end + 20 * kMs), 1e-7);  // the rate goes on
  expect_near(stream.lookup(end + 7 * kMs), at(end + 7 * kMs), 1e-7);
  expect_near(stream.lookup(kStart - 20 * kMs), at(kStart - 20 * kMs), 1e-7);
  expect_near(stream.lookup(kStart - 3 * kMs), at(kStart - 3 * kMs), 1e-7);
  EXPECT_EQ(stream.lookup(end + 20 * kMs + 1).status, OrientationStatus::after_end);
  EXPECT_EQ(stream.lookup(kStart - 20 * kMs - 1).status, OrientationStatus::before_start);
  EXPECT_EQ(stream.lookup(std::numeric_limits<Nanoseconds>::max()).status, OrientationStatus::after_end);
  EXPECT_EQ(stream.lookup(std::numeric_limits<Nanoseconds>::min()).status, OrientationStatus::before_start);
}

TEST(OrientationStream, ExtrapolatesNoFurtherThanItMeasured) {
  // Two samples a microsecond apart, a degree different: their rate is no rate to go on with.
  const Matrix3d other = so3::exp(Vector3d(0, 0, kRadiansPerDegree));
  const OrientationStream stream({{0, Matrix3d::Identity()}, {1000, other}}, {});
  expect_near(stream.lookup(10 * kMs), other, 1e-12);
  expect_near(stream.lookup(-10 * kMs), Matrix3d::Identity(), 1e-12);
  // Noise of a sample is grown by 1 + d/L at most, here 20 ms over 20 ms.
  std::vector<OrientationSample> noisy = samples();
  noisy.back().earth_from_body *= so3::exp(Vector3d(kRadiansPerDegree, 0, 0));
  const Nanoseconds t = noisy.back().time + 20 * kMs;
  const OrientationReading reading = OrientationStream(noisy, {}).lookup(t);
  EXPECT_LT(so3::angle(reading.earth_from_body.transpose() * at(t)), 2.001 * kRadiansPerDegree);
}

TEST(OrientationStream, HoldsASingleSample) {
  const OrientationStream stream({{0, kFirst}}, {});
  expect_near(stream.lookup(15 * kMs), kFirst, 1e-12);
  expect_near(stream.lookup(-15 * kMs), kFirst, 1e-12);
  EXPECT_EQ(stream.lookup(25 * kMs).status, OrientationStatus::after_end);
}

TEST(OrientationStream, RefusesGapsButNotTheirShores) {
  const OrientationStream stream(samples(300, 500), {});
  EXPECT_EQ(stream.lookup(kStart + 400 * kMs).status, OrientationStatus::gap);
  EXPECT_EQ(stream.lookup(kStart + 321 * kMs).status, OrientationStatus::gap);
  EXPECT_EQ(stream.lookup(kStart + 479 * kMs).status, OrientationStatus::gap);
  expect_near(stream.lookup(kStart + 320 * kMs), at(kStart + 320 * kMs), 1e-7);
  expect_near(stream.lookup(kStart + 480 * kMs), at(kStart + 480 * kMs), 1e-7);
  expect_near(stream.lookup(kStart + 300 * kMs), at(kStart + 300 * kMs), 1e-7);
  // 100 ms is the longest that is bridged.
  expect_near(OrientationStream(samples(300, 400), {}).lookup(kStart + 350 * kMs), at(kStart + 350 * kMs), 1e-7);
  EXPECT_EQ(OrientationStream(samples(300, 410), {}).lookup(kStart + 355 * kMs).status, OrientationStatus::gap);
  OrientationStreamOptions wide;
  wide.max_gap = 0.2;
  expect_near(OrientationStream(samples(300, 500), wide).lookup(kStart + 400 * kMs), at(kStart + 400 * kMs), 1e-7);
  EXPECT_EQ(to_string(OrientationStatus::gap), "gap in the orientation");
}

TEST(OrientationStream, DoesNotMeasureARateAcrossAGap) {
  // The sample before the gap is far from where the last two are.
  const OrientationStream stream({{0, so3::exp(Vector3d(2, 0, 0))}, {500 * kMs, kFirst}}, {});
  expect_near(stream.lookup(510 * kMs), kFirst, 1e-12);
}

TEST(OrientationStream, AddsTheOffsetToTheSensorsStamps) {
  OrientationStreamOptions options;
  options.time_offset = -0.25;
  const OrientationStream stream(samples(), options);
  for (const int ms : {-250, -100, 333, 750})
    expect_near(stream.lookup(kStart + ms * kMs), at(kStart + (ms + 250) * kMs), 1e-7);
  EXPECT_EQ(stream.lookup(kStart + 800 * kMs).status, OrientationStatus::after_end);
  EXPECT_EQ(stream.samples().front().time, kStart - 250 * kMs);
}

TEST(OrientationStream, AppliesTheMounting) {
  OrientationStreamOptions options;
  options.body_from_camera = so3::exp(Vector3d(-0.2, 1.3, 0.4));
  const OrientationReading reading = OrientationStream(samples(), options).lookup(kStart + 123 * kMs);
  EXPECT_TRUE(reading.earth_from_camera.isApprox(at(kStart + 123 * kMs) * options.body_from_camera, 1e-6));
}

TEST(OrientationStream, RefusesWhatItCannotUse) {
  EXPECT_THROW(OrientationStream({}, {}), Error);
  EXPECT_THROW(OrientationStream({{1, kFirst}, {1, kFirst}}, {}), Error);
  EXPECT_THROW(OrientationStream({{2, kFirst}, {1, kFirst}}, {}), Error);
  EXPECT_THROW(OrientationStream({{1, -Matrix3d::Identity()}}, {}), Error);
  EXPECT_THROW(OrientationStream({{1, std::nan("") * kFirst}}, {}), Error);
  OrientationStreamOptions options;
  options.max_gap = 0;
  EXPECT_THROW(OrientationStream(samples(), options), Error);
  options = {};
  options.max_extrapolation = -1;
  EXPECT_THROW(OrientationStream(samples(), options), Error);
  options = {};
  options.time_offset = 1e10;
  EXPECT_THROW(OrientationStream(samples(), options), Error);
  options = {};
  options.body_from_camera(0, 0) = -1;
  EXPECT_THROW(OrientationStream(samples(), options), Error);
}

}  // namespace
}  // namespace plumbline
