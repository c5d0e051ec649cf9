// A place is recognised by what it has that others have not (docs/method.md §9). The model is what a camera would see.
#include "place/relocaliser.h"

#include <gtest/gtest.h>

#include "backend/backend.h"
#include "sim/analytic_scene.h"
#include "support/scenes.h"
#include "tracking/live_frame.h"

namespace plumbline {
namespace {

const Pinhole kCamera = test::pinhole(160, 120);

Parameters parameters() {
  Parameters parameters;
  parameters.tracking.finest_level = 0;  // of images of a quarter of the size
  return parameters;
}

/// A place found, of which everything says that it is the right one.
FoundPlace certain_place() {
  FoundPlace place;
  TrackingResult& result = place.evidence.result;
  result.pairs = result.inliers = 9000;
  result.inlier_fraction = 0.9;
  result.pose_covariance = 0.002 * 0.002 * Matrix6d::Identity();
  place.evidence.depth = DepthComparison{{10000, 9500, 10, 9400}};
  place.evidence.detail = {4000, 2000, 1900};
  return place;
}

TEST(PlaceEvidence, MustHoldItsPosition) {
  PlaceEvidence evidence = certain_place().evidence;
  EXPECT_NEAR(evidence.uncertainty(), 0.002, 1e-9);
  EXPECT_TRUE(evidence.meets(kRecognised));
  evidence.result.pose_covariance(4, 4) = 0.01 * 0.01;  // along a corridor
  EXPECT_NEAR(evidence.uncertainty(), 0.01, 1e-9);
  EXPECT_FALSE(evidence.meets(kRecognised));
  EXPECT_TRUE(evidence.meets(kOpen)) << "where next to nothing is seen through that is enough";
  EXPECT_TRUE(evidence.meets(kExpected)) << "where it was expected, too";
  evidence.depth = DepthComparison{{10000, 9500, 200, 9200}};
  EXPECT_FALSE(evidence.meets(kOpen));
  EXPECT_TRUE(evidence.meets(kExpected));
  EXPECT_TRUE(evidence.meets(kOnTrial));
  evidence.result.pose_covariance.setZero();  // of a singular registration
  EXPECT_FALSE(evidence.meets(kExpected));
}

TEST(FoundPlace, IsClearUnlessAnythingElseIsLikely) {
  EXPECT_TRUE(certain_place().is_clear());
  FoundPlace place = certain_place();
  place.rival = 0.7;
  EXPECT_FALSE(place.is_clear()) << "another place fits nearly as well";
  place = certain_place();
  place.evidence.detail.matched = 1540;
  EXPECT_GT(place.evidence.detail.support(), kDetailRecognised);
  EXPECT_FALSE(place.is_clear()) << "a quarter of what stands there is elsewhere";
  place.evidence.detail = {4000, 200, 200};
  EXPECT_FALSE(place.is_clear()) << "hardly anything but walls";
  place = certain_place();
  place.evidence.result.pose_covariance *= 9;
  EXPECT_FALSE(place.is_clear());
  place.is_expected = true;
  EXPECT_TRUE(place.is_clear()) << "the camera was seen there just before";
}

class RelocaliserTest : public testing::Test {
 protected:
  RelocaliserTest() { live_.prepare(sim::render(sim::desk_corner(), kCamera, here_, 0, 5000, false)); }

  /// What stands here, and the same again kApart farther on.
  void render_twins(const Viewpoint& from, DepthPyramid* levels) const {
    const SE3& pose = from.world_from_camera;
    const double shift = pose.translation().x() > kApart / 2 ? kApart : 0;
    const SE3 as_here(pose.rotation(), pose.translation() - Eigen::Vector3d(shift, 0, 0));
    for (DepthLevel& level : *levels)
      level = test::to_level(*backend_, level.camera, test::view_of(scene_, level.camera, as_here));
  }
  PlaceQuery query() const { return {{live_.pyramid(), std::nullopt}, {}, {}, {here_}}; }
  void remember(const SE3& pose) { relocaliser_.remember({live_.pyramid(), std::nullopt}, {pose}); }

  static constexpr double kApart = 20;  // metres
  sim::AnalyticScene scene_ = sim::desk_corner();
  std::shared_ptr<Backend> backend_ = make_backend("cpu", 1);
  SE3 here_ = sim::orbit().front().world_from_camera,
      there_ = {here_.rotation(), here_.translation() + Eigen::Vector3d(kApart, 0, 0)};
  LiveFrame live_{kCamera, parameters().preprocess, pyramid_levels(parameters().tracking), *backend_, false, 0};
  Relocaliser relocaliser_{parameters(), kCamera, *backend_,
                           [this](const Viewpoint& from, DepthPyramid* levels) { render_twins(from, levels); }};
};

TEST_F(RelocaliserTest, APlaceIsRecognisedAndClear) {
  remember(here_);
  const Relocaliser::Search search = relocaliser_.find(query());
  ASSERT_TRUE(search.place);
  EXPECT_LT((search.place->evidence.result.world_from_camera.translation() - here_.translation()).norm(), 0.005);
  EXPECT_TRUE(search.place->is_clear());
}

// A frame that shows one of two equal places is of neither, as long as the camera may have gone to both. It is looked
// for twice as far as cameras are usually carried.
TEST_F(RelocaliserTest, OfTwoThatLookTheSameNoneIsRecognised) {
  remember(here_);
  remember(there_);
  PlaceQuery both = query();
  EXPECT_FALSE(relocaliser_.find(both).place);
  both.reach = 0.6 * kApart;
  EXPECT_FALSE(relocaliser_.find(both).place);
  both.reach = 0.4 * kApart;
  const Relocaliser::Search search = relocaliser_.find(both);
  ASSERT_TRUE(search.place) << "the other one is out of reach";
  EXPECT_LT((search.place->evidence.result.world_from_camera.translation() - here_.translation()).norm(), 0.005);
}

/// A corner of a room with a ball on its floor.
sim::AnalyticScene corner(double ball_x) {
  sim::AnalyticScene scene;
  scene.primitives = {sim::plane({0, 0, 0}, {0, 0, 1}), sim::plane({-1.5, 0, 0}, {1, 0, 0}),
                      sim::plane({0, -1.5, 0}, {0, 1, 0}), sim::sphere({ball_x, -0.7, 0.25}, 0.25)};
  return scene;
}

// Another room of the same kind: of what can be seen only the ball is elsewhere, less than the other tests let pass.
TEST_F(RelocaliserTest, APlaceThatHasTheSameWallsIsNotRecognised) {
  here_ = sim::look_at({1.4, 1.2, 1.4}, {-0.6, -0.6, 0.5});
  scene_ = corner(0.2);
  live_.prepare(sim::render(corner(-0.7), kCamera, here_, 0, 5000, false));
  remember(here_);
  EXPECT_FALSE(relocaliser_.find(query()).place);
}

}  // namespace
}  // namespace plumbline
