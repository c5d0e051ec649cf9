// Poses out of motions between them: derivatives, a ring that closes, a loop that lies, and where up is.
#include "graph/pose_graph.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/random.h"
#include "plumbline/angles.h"

namespace plumbline {
namespace {

Vector6d draw(Random* random, double rotation, double translation) {
  Vector6d v;
  for (int i = 0; i < 6; ++i) v[i] = (i < 3 ? rotation : translation) * random->normal();
  return v;
}

SE3 moved(const SE3& pose, const Vector6d& by) {
  return {so3::exp(Eigen::Vector3d(by.head<3>())) * pose.rotation(), pose.translation() + by.tail<3>()};
}

Matrix6d covariance(double rotation, double translation) {
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(rotation * rotation), Eigen::Vector3d::Constant(translation * translation);
  return variance.asDiagonal();
}

TEST(PoseGraph, DerivativesAreThoseOfTheResidual) {
  Random random(7);
  for (int trial = 0; trial < 5; ++trial) {
    const SE3 a = SE3::exp(draw(&random, 1, 2)), b = SE3::exp(draw(&random, 1, 2));
    const SE3 z = moved(a.inverse() * b, draw(&random, 0.3, 0.3));
    const ConstraintJacobians j = constraint_jacobians(a, b, z);
    constexpr double kStep = 1e-6;
    for (int i = 0; i < 6; ++i) {
      const Vector6d step = kStep * Vector6d::Unit(i);
      const Vector6d by_first =
          (constraint_residual(moved(a, step), b, z) - constraint_residual(moved(a, -step), b, z)) / (2 * kStep);
      const Vector6d by_second =
          (constraint_residual(a, moved(b, step), z) - constraint_residual(a, moved(b, -step), z)) / (2 * kStep);
      EXPECT_LT((by_first - j.first.col(i)).norm(), 1e-6);
      EXPECT_LT((by_second - j.second.col(i)).norm(), 1e-6);
    }
  }
}

/// Round a circle of 4 m, tracked with errors that add up.
class Ring : public testing::Test {
 protected:
  static constexpr std::size_t kNodes = 60;
  static constexpr double kTurn = 0.004, kShift = 0.01;  // radians, metres: of a step

  Ring() {
    Random random(3);
    for (std::size_t i = 0; i < kNodes; ++i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / (kNodes - 1);
      truth_.push_back({so3::exp(Eigen::Vector3d(0, 0, angle)), {4 * std::cos(angle), 4 * std::sin(angle), 0}});
    }
    graph_.world_from_node.push_back(truth_.front());
    for (std::size_t i = 0; i + 1 < kNodes; ++i) {
      const SE3 step = moved(truth_[i].inverse() * truth_[i + 1], draw(&random, kTurn, kShift));
      graph_.constraints.push_back({i, i + 1, step, covariance(kTurn, kShift)});
      graph_.world_from_node.push_back(graph_.world_from_node.back() * step);
    }
  }
  void close(std::size_t first, std::size_t second, const Vector6d& error) {
    graph_.constraints.push_back(
        {first, second, moved(truth_[first].inverse() * truth_[second], error), covariance(0.002, 0.004), 4});
  }
  double rms(const std::vector<SE3>& poses) const {
    double sum = 0;
    for (std::size_t i = 0; i < kNodes; ++i) sum += (poses[i].translation() - truth_[i].translation()).squaredNorm();
    return std::sqrt(sum / kNodes);
  }

  /// Of the final node beside the first, which stand at one place.
  static double end_error(const std::vector<SE3>& poses) {
    return (poses.front().inverse() * poses.back()).translation().norm();
  }

  std::vector<SE3> truth_;
  PoseGraph graph_;
};

TEST_F(Ring, StaysWhereNothingContradicts) {
  const auto poses = optimise(graph_);
  ASSERT_TRUE(poses);
  for (std::size_t i = 0; i < kNodes; ++i)
    EXPECT_LT(pose_difference((*poses)[i], graph_.world_from_node[i]).norm(), 1e-9);
}

TEST_F(Ring, ClosesByItsLoops) {
  const double before = rms(graph_.world_from_node), gap = end_error(graph_.world_from_node);
  for (std::size_t i = 0; i < 4; ++i) close(i, kNodes - 1 - i, Vector6d::Zero());
  const auto poses = optimise(graph_);
  ASSERT_TRUE(poses);
  EXPECT_GT(gap, 0.1);
  EXPECT_LT(end_error(*poses), 0.005);
  EXPECT_LT(rms(*poses), before);
  EXPECT_LT(squared_error(graph_.constraints.back(), *poses), squared_error(graph_.constraints.back(), truth_) + 6);
  const auto again = optimise(graph_);
  ASSERT_TRUE(again);
  for (std::size_t i = 0; i < kNodes; ++i) EXPECT_EQ((*again)[i].translation(), (*poses)[i].translation());
}

TEST_F(Ring, WithstandsALoopThatLies) {
  for (std::size_t i = 0; i < 4; ++i) close(i, kNodes - 1 - i, Vector6d::Zero());
  const auto honest = optimise(graph_);
  Vector6d lie = Vector6d::Zero();
  lie[3] = 1;
  close(10, 40, lie);
  const auto deceived = optimise(graph_);
  ASSERT_TRUE(honest && deceived);
  EXPECT_LT(rms(*deceived), rms(*honest) + 0.05);
  graph_.constraints.back().robust = 0;
  const auto trusting = optimise(graph_);
  ASSERT_TRUE(trusting);
  EXPECT_GT(rms(*trusting), rms(*honest) + 0.15) << "the kernel is what withstands";
}

TEST_F(Ring, UpHoldsTheTilt) {
  // All tilted alike, by as much as the first is held to be right.
  PoseGraph tilted = graph_;
  tilted.constraints.front().covariance = covariance(0.1, 0.1);
  const SE3 tilt(so3::exp(Eigen::Vector3d(0.05, 0, 0)), Eigen::Vector3d::Zero());
  for (std::size_t i = 1; i < kNodes; ++i) {
    tilted.world_from_node[i] = tilt * tilted.world_from_node[i];
    tilted.ups.push_back(
        {i, truth_[i].rotation().transpose() * Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitZ(), radians(0.5)});
  }
  const auto poses = optimise(tilted);
  ASSERT_TRUE(poses);
  const Eigen::Vector3d up = (*poses)[30].rotation() * truth_[30].rotation().transpose() * Eigen::Vector3d::UnitZ();
  EXPECT_LT(std::acos(up.z()), radians(0.7));
}

TEST(PoseGraph, WithoutConstraintsThereIsNothingToSolve) { EXPECT_FALSE(optimise({{SE3(), SE3()}, {}, {}})); }

}  // namespace
}  // namespace plumbline
