// The 6×6 solver: exact where the equations hold everything, honest about rank where they do not.
#include "tracking/solver.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>
#include <limits>

#include "plumbline/se3.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

using kernels::Solution;
using kernels::solve;

/// The normal equations of point-to-plane pairs: H = Σ a aᵀ with a = (p × n, n), and b = H ξ for a known step ξ.
struct Equations {
  Matrix6d h = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();

  void add(const Eigen::Vector3d& p, const Eigen::Vector3d& n, const Vector6d& xi) {
    Vector6d a;
    a << p.cross(n), n;
    h += a * a.transpose();
    b += a * a.dot(xi);
  }
};

const Vector6d kStep = (Vector6d() << 0.01, -0.02, 0.005, 0.03, 0.01, -0.04).finished();

/// A corner of a room, 2 m away: three planes hold all six directions. `unit` is the length of a metre.
Equations corner(double unit = 1) {
  test::Random random(1);
  Vector6d step = kStep;
  step.tail<3>() *= unit;
  Equations equations;
  for (int i = 0; i < 600; ++i) {
    Eigen::Vector3d p(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    p[i % 3] = 1;
    equations.add((p + Eigen::Vector3d(0, 0, 2)) * unit, -Eigen::Vector3d::Unit(i % 3), step);
  }
  return equations;
}

TEST(Solver, SolvesWellPosedEquations) {
  const Equations equations = corner();
  const Solution solution = solve(equations.h, equations.b, 1e6);
  EXPECT_EQ(solution.rank, 6);
  EXPECT_LT((solution.step - kStep).norm(), 1e-12);
  EXPECT_GT(condition(equations.h), 1);
  EXPECT_LT(condition(equations.h), 1e4);
}

TEST(Solver, AnySymmetricPositiveDefiniteMatrix) {
  test::Random random(2);
  for (int i = 0; i < 50; ++i) {
    Matrix6d a;
    for (int k = 0; k < 36; ++k) a(k / 6, k % 6) = random.uniform(-1, 1);
    const Matrix6d h = a * a.transpose() + 0.1 * Matrix6d::Identity();
    Vector6d x;
    for (int k = 0; k < 6; ++k) x[k] = random.uniform(-1, 1);
    const Solution solution = solve(h, h * x, 1e12);
    EXPECT_EQ(solution.rank, 6);
    EXPECT_LT((solution.step - x).norm(), 1e-9);
  }
}

/// A matrix with these eigenvalues about axes drawn at random. Its blocks' traces are what they are: scaling changes
/// the eigenvalues, so the oracle scales as well.
TEST(Solver, LeavesOutTheSameDirectionsAsEigenDoes) {
  test::Random random(7);
  for (int i = 0; i < 200; ++i) {
    Matrix6d a;
    for (int k = 0; k < 36; ++k) a(k / 6, k % 6) = random.uniform(-1, 1);
    const Matrix6d axes = Eigen::HouseholderQR<Matrix6d>(a).householderQ();
    Vector6d values, b;
    for (int k = 0; k < 6; ++k) values[k] = std::pow(10, random.uniform(-12, 3));
    for (int k = 0; k < 6; ++k) b[k] = random.uniform(-1, 1);
    const Matrix6d h = axes * values.asDiagonal() * axes.transpose();
    const double scale = kernels::rotation_scale(h);
    const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(kernels::scaled(h, scale));
    Vector6d rhs = b, step = Vector6d::Zero();
    rhs.head<3>() *= scale;
    int rank = 0;
    for (int k = 0; k < 6; ++k) {
      if (!(eigen.eigenvalues()[k] * 1e6 > eigen.eigenvalues()[5])) continue;
      step += eigen.eigenvectors().col(k) * (eigen.eigenvectors().col(k).dot(rhs) / eigen.eigenvalues()[k]);
      ++rank;
    }
    step.head<3>() *= scale;
    const Solution solution = solve(h, b, 1e6);
    EXPECT_EQ(solution.rank, rank) << i;
    EXPECT_LT((solution.step - step).norm(), 1e-7 * step.norm()) << i;
  }
}

TEST(Solver, DoesNotDependOnTheUnitOfLength) {
  const Equations metres = corner();
  for (const double unit : {1e-3, 1e3, 1e5}) {
    const Equations other = corner(unit);
    Solution solution = solve(other.h, other.b, 1e6);
    solution.step.tail<3>() /= unit;
    EXPECT_EQ(solution.rank, 6) << unit;
    EXPECT_NEAR(condition(other.h) / condition(metres.h), 1, 1e-6) << unit;
    EXPECT_LT((solution.step - kStep).norm(), 1e-9) << unit;
  }
}

TEST(Solver, RankDoesNotDependOnTheUnitEither) {
  for (const double unit : {1e-3, 1.0, 1e3}) {
    Equations plane;
    test::Random random(3);
    for (int i = 0; i < 300; ++i)
      plane.add(Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), 2) * unit, -Eigen::Vector3d::UnitZ(),
                kStep);
    EXPECT_EQ(solve(plane.h, plane.b, 1e6).rank, 3) << unit;
  }
}

TEST(Solver, APlaneHoldsThreeDirections) {
  Equations equations;
  test::Random random(4);
  // A move along the normal and a tilt: what a plane can tell, and something that it cannot.
  Vector6d visible, hidden;
  visible << 0.01, -0.02, 0, 0, 0, -0.03;
  hidden << 0, 0, 0.3, 0.2, -0.1, 0;
  const Eigen::Vector3d n = -Eigen::Vector3d::UnitZ();
  for (int i = 0; i < 500; ++i) equations.add({random.uniform(-1, 1), random.uniform(-1, 1), 0}, n, visible + hidden);
  const Solution solution = solve(equations.h, equations.b, 1e6);
  EXPECT_EQ(solution.rank, 3);
  EXPECT_GT(condition(equations.h), 1e12);
  EXPECT_LT((solution.step - visible).norm(), 1e-9) << "no step in directions that nothing holds";
}

TEST(Solver, AnEdgeHoldsFiveDirections) {
  // Two planes that meet along x: sliding along the edge is free.
  Equations equations;
  test::Random random(5);
  for (int i = 0; i < 500; ++i) {
    const double along = random.uniform(-1, 1), across = random.uniform(0, 1);
    if (i % 2 == 0) equations.add({along, across, 0}, Eigen::Vector3d::UnitZ(), kStep);
    if (i % 2 == 1) equations.add({along, 0, across}, Eigen::Vector3d::UnitY(), kStep);
  }
  const Solution solution = solve(equations.h, equations.b, 1e6);
  EXPECT_EQ(solution.rank, 5);
  EXPECT_NEAR(solution.step[3], 0, 1e-9) << "not along the edge";
  EXPECT_LT((equations.h * solution.step - equations.b).norm(), 1e-9 * equations.b.norm());
}

TEST(Solver, ASphereHoldsThreeDirections) {
  // It may turn about its own centre; what is held is the move of the centre.
  const Eigen::Vector3d centre(0.3, -0.2, 2);
  Equations equations;
  test::Random random(6);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d n = random.direction();
    equations.add(centre + 0.3 * n, n, kStep);
  }
  const Solution solution = solve(equations.h, equations.b, 1e6);
  EXPECT_EQ(solution.rank, 3);
  const auto move_of_centre = [&](const Vector6d& xi) {
    return Eigen::Vector3d(xi.head<3>().cross(centre) + xi.tail<3>());
  };
  EXPECT_LT((move_of_centre(solution.step) - move_of_centre(kStep)).norm(), 1e-9);
  EXPECT_LT(solution.step.norm(), kStep.norm() + 1e-9) << "the rest is left out";
}

TEST(Solver, TheLimitOfConditionDecides) {
  Matrix6d h = Matrix6d::Identity();
  h(5, 5) = 1e-4;
  const Vector6d b = h * kStep;
  EXPECT_EQ(solve(h, b, 1e6).rank, 6);
  EXPECT_LT((solve(h, b, 1e6).step - kStep).norm(), 1e-12);
  const Solution strict = solve(h, b, 1e3);
  EXPECT_EQ(strict.rank, 5);
  EXPECT_EQ(strict.step[5], 0);
  EXPECT_NEAR(condition(h), 1e4, 1e-3) << "it is told all the same";
}

TEST(Solver, NoEquationsGiveNoStep) {
  const Solution solution = solve(Matrix6d::Zero(), Vector6d::Zero(), 1e6);
  EXPECT_EQ(solution.rank, 0);
  EXPECT_EQ(solution.step.norm(), 0);
  EXPECT_TRUE(std::isinf(condition(Matrix6d::Zero())));
}

TEST(Solver, WhatIsNotANumberGivesNoStep) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const Equations good = corner();
  for (const double bad : {nan, inf, -inf}) {
    Equations equations = good;
    equations.h(2, 4) = equations.h(4, 2) = bad;
    EXPECT_EQ(solve(equations.h, equations.b, 1e6).rank, 0);
    EXPECT_EQ(solve(equations.h, equations.b, 1e6).step.norm(), 0);
    equations = good;
    equations.b[1] = bad;
    EXPECT_EQ(solve(equations.h, equations.b, 1e6).rank, 0);
    EXPECT_EQ(solve(equations.h, equations.b, 1e6).step.norm(), 0);
  }
}

}  // namespace
}  // namespace plumbline
