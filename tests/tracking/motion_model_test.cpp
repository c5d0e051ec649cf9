// What is expected of a hand.
#include "tracking/motion_model.h"
#include "plumbline/se3.h"

#include <gtest/gtest.h>

#include <cmath>

namespace plumbline {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kFrame = 1.0 / 30;

TEST(MotionModel, WithoutMemoryTheCameraStays) {
  MotionModel model(0.75, 0);
  model.observe({0, 0, 0}, {0.02, 0, 0}, Matrix3d::Identity() * 1e-8, kFrame);
  const PositionPrediction belief = model.predict({0.02, 0, 0}, 2 * kFrame);
  EXPECT_EQ(belief.mean, Vector3d(0.02, 0, 0));
  EXPECT_LT((belief.covariance - std::pow(0.75 * 2 * kFrame, 2) * Matrix3d::Identity()).norm(), 1e-12);
}

TEST(MotionModel, GoesOnWithAVelocityThatWasSeenAndForgetsIt) {
  MotionModel model(0.75, 0.3);
  model.observe({0, 0, 0}, {0.02, 0, 0}, Matrix3d::Identity() * 1e-8, kFrame);
  const double kept = std::exp(-kFrame / 0.3);
  const PositionPrediction next = model.predict({0.02, 0, 0}, kFrame);
  EXPECT_NEAR(next.mean.x(), 0.02 + kept * 0.02, 1e-12);
  EXPECT_LT(next.covariance(0, 0), 0.3 * std::pow(0.75 * kFrame, 2)) << "surer than without having seen it";
  const PositionPrediction late = model.predict({0.02, 0, 0}, 3);
  EXPECT_NEAR(late.mean.x(), 0.02, 1e-4) << "ten times the memory later nothing is left";
  EXPECT_NEAR(late.covariance(0, 0), std::pow(0.75 * 3, 2), 1e-3);
}

TEST(MotionModel, KnowsWhichDirectionTheImagesShowed) {
  MotionModel model(0.75, 0.3);
  const Matrix3d covariance = Vector3d(1e-8, std::pow(0.75 * kFrame, 2), 1e-8).asDiagonal();
  model.observe({0, 0, 0}, {0.01, 0, 0}, covariance, kFrame);
  const Matrix3d next = model.predict({0.01, 0, 0}, kFrame).covariance;
  EXPECT_NEAR(next(1, 1), std::pow(0.75 * kFrame, 2), 1e-9) << "nothing was learnt about y";
  EXPECT_LT(next(0, 0), 0.3 * next(1, 1));
}

TEST(MotionModel, BeforeTheFirstFrameItStands) {
  EXPECT_EQ(MotionModel(0.75, 0.3).predict({1, 2, 3}, kFrame).mean, Vector3d(1, 2, 3));
}

TEST(SteadyTurn, GoesOnAtTheRateThatWasSeen) {
  const Vector3d axis = Vector3d(1, -2, 0.5).normalized();
  const Matrix3d first = so3::exp(Vector3d(0.3, 0.2, -1));
  const auto turned = [&](double radians) -> Matrix3d { return first * so3::exp(radians * axis); };
  SteadyTurn turn;
  EXPECT_LT((turn.predict(first, kFrame) - first).norm(), 1e-12) << "nothing was seen yet";
  turn.observe(first, turned(0.1), kFrame);
  EXPECT_LT((turn.predict(turned(0.1), kFrame) - turned(0.2)).norm(), 1e-9);
  EXPECT_LT((turn.predict(turned(0.1), 0.5 * kFrame) - turned(0.15)).norm(), 1e-9) << "frames may come unevenly";
  turn.forget();
  EXPECT_LT((turn.predict(turned(0.1), kFrame) - turned(0.1)).norm(), 1e-12);
}

}  // namespace
}  // namespace plumbline
