#include "calibration/hand_eye.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "calibration/simulated_recording.h"
#include "calibration/time_offset.h"
#include "plumbline/angles.h"
#include "plumbline/orientation.h"
#include "plumbline/se3.h"
#include "plumbline/trajectory.h"

namespace plumbline {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d random_rotation(Random& random) {
  return Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal())
      .normalized()
      .toRotationMatrix();
}

/// Turns of 10° to 60° about axes in all directions; the camera's with an error.
Turns turns_of(Random& random, const Matrix3d& body_from_camera, double noise, int count = 30) {
  Turns turns;
  for (int i = 0; i < count; ++i) {
    const Vector3d axis = Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    const Vector3d error = noise * Vector3d(random.normal(), random.normal(), random.normal());
    const Vector3d a = random.uniform(10, 60) * kRadiansPerDegree * axis;
    turns.body.push_back(body_from_camera * a);
    turns.camera.push_back(so3::log(so3::exp(error) * so3::exp(a)));
  }
  return turns;
}

double degrees_between(const Matrix3d& a, const Matrix3d& b) {
  return so3::angle(a.transpose() * b) / kRadiansPerDegree;
}

/// As the paper writes it: (MᵀM)^(−1/2) Mᵀ of M = Σ β αᵀ, with α that of the body.
Matrix3d park_martin_by_the_letter(const Turns& turns) {
  Matrix3d m = Matrix3d::Zero();
  for (std::size_t i = 0; i < turns.camera.size(); ++i) m += turns.camera[i] * turns.body[i].transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(m.transpose() * m);
  return solver.operatorInverseSqrt() * m.transpose();
}

TEST(HandEye, ExactTurnsGiveTheMountingBack) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    // Every fourth is half a turn, where Tsai and Lenz' own form has no solution.
    const Vector3d axis = Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    const Matrix3d truth = i % 4 == 0 ? so3::exp(std::numbers::pi * axis) : random_rotation(random);
    const Turns turns = turns_of(random, truth, 0, 5);
    EXPECT_LT(degrees_between(fit_mounting(turns).proper, truth), 1e-6);
    EXPECT_LT(degrees_between(tsai_lenz(turns), truth), 1e-6);
    EXPECT_LT(turn_residual(turns, truth), 1e-9);
    EXPECT_NEAR(fit_mounting(turns).mirrored.determinant(), -1, 1e-9);
  }
}

TEST(HandEye, TwoClosedFormsAgreeOnTurnsThatErr) {
  Random random(2);
  double tsai = 0, park = 0;
  for (int i = 0; i < 50; ++i) {
    const Matrix3d truth = random_rotation(random);
    const Turns turns = turns_of(random, truth, 0.3 * kRadiansPerDegree);
    const Matrix3d a = tsai_lenz(turns), b = fit_mounting(turns).proper;
    EXPECT_LT(degrees_between(b, park_martin_by_the_letter(turns)), 1e-6);
    EXPECT_LT(degrees_between(a, b), 0.3);
    tsai = std::max(tsai, degrees_between(a, truth));
    park = std::max(park, degrees_between(b, truth));
    // Either is where its residual is least: a small turn makes it worse.
    for (int axis = 0; axis < 3; ++axis)
      for (const double step : {-2 * kRadiansPerDegree, 2 * kRadiansPerDegree})
        EXPECT_GT(turn_residual(turns, so3::exp(step * Vector3d::Unit(axis)) * b), turn_residual(turns, b));
  }
  EXPECT_LT(tsai, 0.4);
  EXPECT_LT(park, 0.4);
}

TEST(HandEye, TurnsThatDetermineNothingStillGiveARotation) {
  const Turns none, still{{Vector3d::Zero()}, {Vector3d::Zero()}};
  const Turns one_axis{{Vector3d(0.3, 0, 0), Vector3d(-0.5, 0, 0)}, {Vector3d(0, 0.3, 0), Vector3d(0, -0.5, 0)}};
  for (const Turns& turns : {none, still, one_axis})
    for (const Matrix3d& m : {tsai_lenz(turns), fit_mounting(turns).proper}) {
      EXPECT_TRUE((m * m.transpose()).isIdentity(1e-9));
      EXPECT_GT(m.determinant(), 0);
      EXPECT_LT(turn_residual(turns, m), 1e-6);
    }
}

TEST(TimeOffset, SpeedsTellItWithinTwoMilliseconds) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const test::Recording r = test::record({.seed = seed, .ideal = true, .exact_poses = true});
    const auto found = correlate_angular_speed(r.camera, r.stream());
    ASSERT_FALSE(found.empty());
    double nearest = 1;
    for (const OffsetCandidate& c : found) nearest = std::min(nearest, std::abs(c.offset - r.time_offset));
    EXPECT_LT(nearest, 0.002) << seed;
    EXPECT_GT(found.front().correlation, 0.9);
  }
}

TEST(TimeOffset, IsSearchedAsFarAsAskedFor) {
  test::Recording r = test::record({.seed = 3, .ideal = true});
  for (OrientationSample& s : r.sensor) s.time += 3 * kNanosecondsPerSecond;
  OffsetSearch far;
  far.longest = 4;
  const auto found = correlate_angular_speed(r.camera, r.stream(), far);
  ASSERT_FALSE(found.empty());
  EXPECT_NEAR(found.front().offset, r.time_offset - 3, 0.1);
  for (const OffsetCandidate& c : correlate_angular_speed(r.camera, r.stream())) EXPECT_LT(std::abs(c.offset), 1.001);
}

TEST(TimeOffset, WithoutMotionOrOverlapThereIsNone) {
  test::Recording r = test::record({.seed = 4, .ideal = true});
  Trajectory still = r.camera;
  for (StampedPose& pose : still) pose.world_from_camera = SE3();
  EXPECT_TRUE(correlate_angular_speed(still, r.stream()).empty());
  EXPECT_TRUE(correlate_angular_speed({r.camera.begin(), r.camera.begin() + 5}, r.stream()).empty());
  for (StampedPose& pose : still) pose.time += 100 * kNanosecondsPerSecond;
  EXPECT_TRUE(correlate_angular_speed(still, r.stream()).empty());
}

}  // namespace
}  // namespace plumbline
