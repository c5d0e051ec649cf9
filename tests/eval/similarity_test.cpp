#include "eval/similarity.h"

#include <gmock/gmock.h>

#include <cmath>

#include "plumbline/time.h"

namespace plumbline::eval {
namespace {

/// A path that moves and turns, a tenth of a second a pose.
Trajectory path() {
  Trajectory poses;
  for (int i = 0; i < 40; ++i) {
    const double s = 0.1 * i;
    poses.push_back({i * kNanosecondsPerSecond / 10, SE3(so3::exp(Eigen::Vector3d(0.3 * s, std::sin(s), 0.2 * s)),
                                                         Eigen::Vector3d(std::sin(2 * s), 0.5 * s, std::cos(s)))});
  }
  return poses;
}

TEST(Similarity, TheScaleOfASmallerPath) {
  EXPECT_NEAR(similarity_scale(path(), scaled(path(), 0.25)), 4, 1e-9);
  EXPECT_NEAR(similarity_scale(path(), path()), 1, 1e-9);
}

TEST(Similarity, InvertedPosesAreRecognised) {
  Trajectory inverted = path();
  for (StampedPose& pose : inverted) pose.world_from_camera = pose.world_from_camera.inverse();
  const auto error = error_if_inverted(path(), inverted);
  ASSERT_TRUE(error);
  EXPECT_LT(*error, 1e-9);
  EXPECT_FALSE(error_if_inverted(path(), path())) << "it fits as it is";
  EXPECT_FALSE(error_if_inverted(path(), scaled(path(), 0.5))) << "that is not what is wrong";
}

}  // namespace
}  // namespace plumbline::eval
