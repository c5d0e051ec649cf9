// What is counted where a live depth image meets a predicted one.
#include <gtest/gtest.h>

#include "backend/backend.h"
#include "backend/maps.h"
#include "support/lane_types.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

class DepthComparisonTest : public test::LaneTest {};

TEST_P(DepthComparisonTest, CountsWhatIsKnownMatchedAndSeenThrough) {
  constexpr int kWidth = 37, kHeight = 19;  // rows end within a lane
  Image<float> live(kWidth, kHeight), model(kWidth, kHeight);
  test::Random random(7);
  double readings = 0, known = 0, behind = 0, matched = 0;
  for (std::size_t i = 0; i < live.pixels.size(); ++i) {
    const auto z = static_cast<float>(random.uniform(0.5, 6));
    live.pixels[i] = random.integer(0, 4) == 0 ? 0 : z + static_cast<float>(random.uniform(-0.4, 0.4));
    model.pixels[i] = random.integer(0, 3) == 0 ? 0 : z;
    if (!(live.pixels[i] > 0)) continue;
    ++readings;
    if (!(model.pixels[i] > 0)) continue;
    ++known;
    const float difference = live.pixels[i] - model.pixels[i];
    behind += difference > std::max(0.10f, 0.05f * model.pixels[i]);
    matched += std::abs(difference) < std::max(0.05f, 0.03f * model.pixels[i]);
  }
  const Plane<float> a = test::to_plane(backend(), live), b = test::to_plane(backend(), model);
  const DepthComparison found = backend().reduce(kernels::CompareDepth{read_only(a), read_only(b)});
  EXPECT_EQ(found.slots[kernels::depth_comparison::kReadings], readings);
  EXPECT_DOUBLE_EQ(found.known(), known / readings);
  EXPECT_DOUBLE_EQ(found.see_through(), behind / known);
  EXPECT_DOUBLE_EQ(found.matched(), matched / known);
  EXPECT_GT(behind, 50);
  EXPECT_GT(matched, 50);
}

TEST_P(DepthComparisonTest, OfNothingAllSharesAreZero) {
  const Plane<float> empty = test::make_plane<float>(backend(), 32, 8);
  const DepthComparison found = backend().reduce(kernels::CompareDepth{read_only(empty), read_only(empty)});
  EXPECT_EQ(found.known() + found.matched() + found.see_through(), 0);
}

PLUMBLINE_ON_EVERY_LANE_TYPE(DepthComparisonTest);

}  // namespace
}  // namespace plumbline
