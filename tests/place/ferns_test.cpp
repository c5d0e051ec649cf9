// Codes of views: alike for views alike, and of use where parts of an image are missing.
#include "place/ferns.h"

#include <gtest/gtest.h>

#include "plumbline/angles.h"
#include "sim/analytic_scene.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

const Pinhole kCamera = test::pinhole(80, 60);

test::View desk(const SE3& world_from_camera) { return test::view_of(sim::desk_corner(), kCamera, world_from_camera); }

Thumbnail thumbnail_of(const test::View& view) {
  return make_thumbnail(view.depth, {view.normal_x, view.normal_y, view.normal_z});
}

SE3 turned(double degrees) {
  const SE3 pose = sim::orbit().front().world_from_camera;
  return pose * SE3(so3::exp(Eigen::Vector3d(0, degrees * kRadiansPerDegree, 0)), {0, 0, 0});
}

TEST(Thumbnail, AveragesCells) {
  test::View view(40, 30);  // 2×2 pixels a cell
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 2; ++x) {
      view.depth.at(x, y) = x == 0 ? 1.0f : 2.0f;
      view.normal_z.at(x, y) = -1;
    }
  view.depth.at(2, 0) = 4;  // without normal
  const Thumbnail small = thumbnail_of(view);
  EXPECT_FLOAT_EQ(small.pixels[0][0], 0.75f) << "mean inverse depth";
  EXPECT_FLOAT_EQ(small.pixels[0][3], -1);
  EXPECT_EQ(small.pixels[1][0], 0);
}

TEST(Ferns, ViewsAreTheMoreAlikeTheLessTheyDiffer) {
  const Ferns ferns;
  const FernCode here = ferns.encode(thumbnail_of(desk(turned(0))));
  EXPECT_EQ(dissimilarity(here, here), 0);
  double previous = 0;
  for (const double degrees : {2.0, 8.0, 25.0}) {
    const double now = dissimilarity(here, ferns.encode(thumbnail_of(desk(turned(degrees)))));
    EXPECT_GT(now, previous) << degrees;
    previous = now;
  }
  EXPECT_GT(previous, 0.3);
}

TEST(Ferns, OfTwoRunsAreTheSame) {
  const Thumbnail view = thumbnail_of(desk(turned(0)));
  EXPECT_EQ(Ferns().encode(view).ferns, Ferns().encode(view).ferns);
}

TEST(Ferns, LeaveOutWhatIsBlank) {
  const Ferns ferns;
  test::View half = desk(turned(0));
  for (int y = 0; y < 60; ++y)
    for (int x = 40; x < 80; ++x) half.depth.at(x, y) = 0;
  const FernCode whole = ferns.encode(thumbnail_of(desk(turned(0)))), part = ferns.encode(thumbnail_of(half));
  EXPECT_EQ(dissimilarity(whole, part), 0) << "what both see is the same";
  EXPECT_EQ(dissimilarity(whole, ferns.encode(Thumbnail())), 1) << "nothing in common";
}

}  // namespace
}  // namespace plumbline
