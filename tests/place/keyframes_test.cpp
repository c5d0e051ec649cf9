// Which views are kept, and in which order they are found.
#include "place/keyframes.h"

#include <gtest/gtest.h>

#include "backend/backend.h"
#include "sim/analytic_scene.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

const Pinhole kCamera = test::pinhole(160, 120);

class KeyframesTest : public testing::Test {
 protected:
  DepthPyramid view(const SE3& pose) const {
    DepthPyramid levels;
    for (int level = 0; level < 3; ++level)
      levels.push_back(test::to_level(*backend_, kCamera.level(level),
                                      test::view_of(sim::desk_corner(), kCamera.level(level), pose)));
    return levels;
  }
  SE3 moved(double metres, double radians) const {
    return start_ * SE3(so3::exp(Eigen::Vector3d(0, radians, 0)), {metres, 0, 0});
  }

  std::shared_ptr<Backend> backend_ = make_backend("cpu", 1);
  SE3 start_ = sim::orbit().front().world_from_camera;
  Keyframes keyframes_{2, *backend_};
};

TEST_F(KeyframesTest, AreAStepApart) {
  EXPECT_NEAR(pose_distance(start_, moved(0.3, 0)), 0.2, 1e-12);
  EXPECT_NEAR(pose_distance(start_, moved(0.3, 0.1)), 0.3, 1e-9);
  const auto offer = [&](const SE3& pose) { return keyframes_.offer({view(pose), {}}, {pose}); };
  EXPECT_TRUE(offer(start_));
  EXPECT_FALSE(offer(moved(0.2, 0.1)));
  EXPECT_TRUE(offer(moved(0.2, 0.2)));
  EXPECT_FALSE(offer(start_)) << "seen again";
  ASSERT_EQ(keyframes_.all().size(), 2u);
  const Keyframe& first = keyframes_.all().front();
  ASSERT_EQ(first.depth.size(), 2u) << "the coarsest two levels";
  EXPECT_EQ(first.depth.front().width, 80);
  EXPECT_EQ(first.depth.back().width, 40);
}

TEST_F(KeyframesTest, TheLikestComesFirstAndTheImpossibleAreLeftOut) {
  for (const double radians : {0.0, 0.3, 0.6, 0.9})
    keyframes_.offer({view(moved(0, radians)), {}}, {moved(0, radians)});
  ASSERT_EQ(keyframes_.all().size(), 4u);
  const FernCode code = keyframes_.encode(view(moved(0, 0.62)));
  const auto nearest = keyframes_.nearest(code, 2, [](const Keyframe&) { return true; });
  ASSERT_EQ(nearest.size(), 2u);
  EXPECT_EQ(nearest.front(), &keyframes_.all()[2]);
  const auto others = keyframes_.nearest(code, 4, [&](const Keyframe& k) { return &k != nearest.front(); });
  EXPECT_EQ(others.size(), 3u);
}

}  // namespace
}  // namespace plumbline
