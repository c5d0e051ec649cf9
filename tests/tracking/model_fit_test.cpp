#include "tracking/model_fit.h"

#include <gtest/gtest.h>

#include "plumbline/se3.h"

namespace plumbline {
namespace {

TEST(ModelFit, BeforeAnythingIsKnownAllErrorMayBeShared) { EXPECT_EQ(ModelFit().repeated_share(), 1); }

TEST(ModelFit, FramesThatFitLikeNoiseAndHoldTheCameraShareNone) {
  ModelFit fit;
  for (int i = 0; i < 60; ++i) fit.observe(0.005, 0.003, 1.0 / 30);
  EXPECT_EQ(fit.repeated_share(), 0);
}

TEST(ModelFit, ResidualsBeyondNoiseAreSharedErrorOfTheLatestFrames) {
  ModelFit fit;
  double before = 0;
  for (int i = 0; i < 60; ++i) fit.observe(0.004, 0.003, 1.0 / 30);
  for (int i = 0; i < 15; ++i) {
    fit.observe(0.014, 0.003, 1.0 / 30);
    EXPECT_GE(fit.repeated_share(), before);
    before = fit.repeated_share();
  }
  EXPECT_EQ(before, 1);
}

TEST(ModelFit, AWallThatFitsWellButLeavesADirectionOpenSharesAll) {
  ModelFit fit;
  for (int i = 0; i < 60; ++i) fit.observe(0.001, 0.03, 1.0 / 30);
  EXPECT_EQ(fit.repeated_share(), 1);
  fit.observe(0.001, 0.003, 1.0 / 30);
  EXPECT_EQ(fit.repeated_share(), 0);
}

TEST(LeastKnown, IsTheWeakestDirectionOfTheImagesAlone) {
  const Eigen::Matrix3d world_from_camera = so3::exp(Eigen::Vector3d(0.3, -0.2, 0.5));
  Vector6d deviations;  // of the images, camera axes: radians, metres
  deviations << 1e-3, 2e-3, 1e-3, 1e-3, 9e-3, 2e-3;
  Matrix6d axes = Matrix6d::Zero();
  axes.topLeftCorner<3, 3>() = axes.bottomRightCorner<3, 3>() = world_from_camera;
  const Matrix6d images = axes * deviations.cwiseAbs2().asDiagonal() * axes.transpose();
  const Matrix6d predicted = 1e-5 * Matrix6d::Identity();
  const Matrix6d solved = (images.inverse() / 10 + predicted.inverse()).inverse();
  EXPECT_NEAR(least_known(world_from_camera, solved, predicted, 10), 9e-3 / 1.5, 1e-6);
  EXPECT_EQ(least_known(world_from_camera, predicted, predicted, 10), kNothingKnown);
}

}  // namespace
}  // namespace plumbline
