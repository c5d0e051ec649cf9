// What stands before walls tells a place from others that have the same walls.
#include "place/detail.h"

#include <gtest/gtest.h>

#include "backend/backend.h"
#include "place/relocaliser.h"
#include "sim/analytic_scene.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

const Pinhole kCamera = test::pinhole(160, 120);

/// A corner of a room with a ball on its floor, if there is one.
sim::AnalyticScene corner(double ball_x, double radius) {
  sim::AnalyticScene scene;
  scene.primitives = {sim::plane({0, 0, 0}, {0, 0, 1}), sim::plane({-1.5, 0, 0}, {1, 0, 0}),
                      sim::plane({0, -1.5, 0}, {0, 1, 0})};
  if (radius > 0) scene.primitives.push_back(sim::sphere({ball_x, -0.7, radius}, radius));
  return scene;
}

class DetailTest : public testing::Test {
 protected:
  std::vector<SurfacePoint> points(const sim::AnalyticScene& scene) const {
    return sample_surface(*backend_, test::to_level(*backend_, kCamera, test::view_of(scene, kCamera, pose_)));
  }
  static double share(const std::vector<SurfacePoint>& points) {
    int beyond = 0;
    for (const std::uint8_t is_beyond : beyond_planes(points)) beyond += is_beyond;
    return beyond / static_cast<double>(points.size());
  }

  std::shared_ptr<Backend> backend_ = make_backend("cpu", 1);
  SE3 pose_ = sim::look_at({1.4, 1.2, 1.4}, {-0.6, -0.6, 0.5});
};

TEST_F(DetailTest, ACornerOfARoomHasNone) {
  EXPECT_EQ(points(corner(0, 0)).size(), 80u * 60u);
  EXPECT_LT(share(points(corner(0, 0))), 0.01);
  EXPECT_GT(share(points(corner(-0.5, 0.7))), kDetailRecognised);
  EXPECT_GT(share(points(sim::desk_corner())), kDetailClear);
}

TEST_F(DetailTest, OfOneViewAgreesWithItself) {
  const DetailComparison same = compare_detail(points(corner(-0.5, 0.7)), points(corner(-0.5, 0.7)));
  EXPECT_EQ(same.matched, same.detail);
  EXPECT_GT(same.support(), kDetailRecognised);
  EXPECT_LT(compare_detail(points(corner(0, 0)), points(corner(0, 0))).support(), 0.01) << "nothing to compare";
}

// Walls and floor are the same, and most pixels show them: depth alone says that the place is the same.
TEST_F(DetailTest, TellsPlacesApartThatHaveTheSameWalls) {
  const test::View here = test::view_of(corner(-0.7, 0.35), kCamera, pose_),
                   there = test::view_of(corner(0.2, 0.35), kCamera, pose_);
  const DepthLevel a = test::to_level(*backend_, kCamera, here), b = test::to_level(*backend_, kCamera, there);
  const DepthComparison depth = backend_->reduce(kernels::CompareDepth{read_only(a.depth), read_only(b.depth)});
  EXPECT_GT(depth.matched(), kRecognised.matched);
  const DetailComparison detail = compare_detail(sample_surface(*backend_, a), sample_surface(*backend_, b));
  EXPECT_GT(detail.detail, 0.08 * detail.readings);
  EXPECT_LT(detail.support(), 0);
}

TEST_F(DetailTest, PixelsWithoutReadingsCountForNothing) {
  test::View blank = test::view_of(corner(-0.5, 0.7), kCamera, pose_);
  for (float& depth : blank.depth.pixels) depth = 0;
  const std::vector<SurfacePoint> none = sample_surface(*backend_, test::to_level(*backend_, kCamera, blank));
  EXPECT_EQ(share(none), 0);
  EXPECT_EQ(compare_detail(none, points(corner(-0.5, 0.7))).support(), 0);
}

}  // namespace
}  // namespace plumbline
