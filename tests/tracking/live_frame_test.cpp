// What the tracker and the fusion get of a frame.
#include "tracking/live_frame.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/frame.h"
#include "plumbline/image.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

class LiveFrameTest : public testing::Test {
 protected:
  LiveFrame make(const PreprocessParameters& parameters = preset("kinectfusion").preprocess, bool color = false) const {
    return {camera_, parameters, 3, *backend_, color};
  }

  Pinhole camera_ = test::pinhole(321, 241);
  std::shared_ptr<Backend> backend_ = make_backend("cpu", 1);
  sim::AnalyticScene scene_ = sim::desk_corner();
  SE3 pose_ = sim::orbit().front().world_from_camera;
  Frame frame_ = sim::render(scene_, camera_, pose_);
};

TEST_F(LiveFrameTest, RawDepthIsAsMeasured) {
  LiveFrame live = make();
  EXPECT_FALSE(live.has_depth());
  live.prepare(frame_);
  EXPECT_TRUE(live.has_depth());
  EXPECT_EQ(live.color(), nullptr);
  const Image<float> raw = download(*backend_, live.raw_depth());
  for (std::size_t i = 0; i < raw.pixels.size(); ++i)
    ASSERT_NEAR(double{raw.pixels[i]}, frame_.depth.pixels[i] / 5000.0, 1e-6);
}

TEST_F(LiveFrameTest, EveryLevelHasDepthAndNormals) {
  LiveFrame live = make();
  live.prepare(frame_);
  ASSERT_EQ(live.pyramid().size(), 3u);
  for (std::size_t l = 0; l < 3; ++l) {
    const DepthLevel& level = live.pyramid()[l];
    EXPECT_EQ(level.camera, camera_.level(static_cast<int>(l)));
    EXPECT_EQ(test::dirty_padding(*backend_, level), 0);
    const test::View view = test::to_view(*backend_, level), truth = test::view_of(scene_, level.camera, pose_);
    std::vector<double> depth_errors, normal_errors;
    for (int v = 0; v < level.camera.height; ++v) {
      for (int u = 0; u < level.camera.width; ++u) {
        if (view.normal(u, v).norm() < 0.5) continue;
        depth_errors.push_back(std::abs(double{view.depth.at(u, v)} - double{truth.depth.at(u, v)}));
        normal_errors.push_back(test::angle_between(view.normal(u, v), truth.normal(u, v)));
      }
    }
    EXPECT_GT(static_cast<double>(normal_errors.size()), 0.6 * level.camera.width * level.camera.height);
    EXPECT_LT(test::quantile(depth_errors, 0.5), 2e-3) << "level " << l;
    EXPECT_LT(test::quantile(normal_errors, 0.5), 2 * kRadiansPerDegree) << "level " << l;
  }
}

TEST_F(LiveFrameTest, WithoutTheFilterTheTrackedDepthIsTheRawDepth) {
  PreprocessParameters parameters = preset("kinectfusion").preprocess;
  parameters.bilateral = false;
  LiveFrame live = make(parameters);
  live.prepare(frame_);
  EXPECT_EQ(download(*backend_, live.raw_depth()).pixels, download(*backend_, live.pyramid().front().depth).pixels);
  LiveFrame smooth = make();
  smooth.prepare(frame_);
  EXPECT_NE(download(*backend_, smooth.raw_depth()).pixels, download(*backend_, smooth.pyramid().front().depth).pixels);
}

TEST_F(LiveFrameTest, AFrameLeavesNothingToTheNext) {
  LiveFrame live = make(), fresh = make();
  live.prepare(sim::render(scene_, camera_, sim::orbit()[100].world_from_camera));
  live.prepare(frame_);
  fresh.prepare(frame_);
  for (std::size_t l = 0; l < 3; ++l) {
    EXPECT_EQ(download(*backend_, live.pyramid()[l].depth).pixels,
              download(*backend_, fresh.pyramid()[l].depth).pixels);
    EXPECT_EQ(download(*backend_, live.pyramid()[l].normal_x).pixels,
              download(*backend_, fresh.pyramid()[l].normal_x).pixels);
  }
}

TEST_F(LiveFrameTest, ABlackFrameHasNoDepth) {
  LiveFrame live = make();
  live.prepare(frame_);
  std::fill(frame_.depth.pixels.begin(), frame_.depth.pixels.end(), std::uint16_t{0});
  live.prepare(frame_);
  EXPECT_FALSE(live.has_depth());
  for (const DepthLevel& level : live.pyramid()) {
    for (const float z : download(*backend_, level.depth).pixels) ASSERT_EQ(z, 0);
  }
}

TEST_F(LiveFrameTest, ReadingsOutOfRangeAreNoDepth) {
  LiveFrame live = make();
  std::fill(frame_.depth.pixels.begin(), frame_.depth.pixels.end(), std::uint16_t{50000});  // 10 m; max_depth is 8 m
  live.prepare(frame_);
  EXPECT_FALSE(live.has_depth());
  frame_.depth.at(3, 4) = 10000;
  live.prepare(frame_);
  EXPECT_TRUE(live.has_depth());
}

TEST_F(LiveFrameTest, AnImageOfAnotherSizeIsAnError) {
  LiveFrame live = make({}, true);
  Frame wrong = frame_;
  wrong.index = 17;
  wrong.depth = DepthImage(320, 241);
  try {
    live.prepare(wrong);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.where(), "frame 17");
    EXPECT_THAT(error.what(), testing::HasSubstr("320x241"));
    EXPECT_THAT(error.what(), testing::HasSubstr("321x241"));
  }
  wrong = frame_;
  wrong.color = ColorImage(321, 240, 3);
  EXPECT_THROW(live.prepare(wrong), Error);
}

TEST_F(LiveFrameTest, ColourIsPacked) {
  LiveFrame live = make({}, true);
  live.prepare(frame_);
  ASSERT_NE(live.color(), nullptr);
  const Image<std::int32_t> packed = download(*backend_, *live.color());
  for (int v = 0; v < camera_.height; ++v) {
    for (int u = 0; u < camera_.width; ++u)
      ASSERT_EQ(packed.at(u, v),
                frame_.color.at(u, v, 0) | frame_.color.at(u, v, 1) << 8 | frame_.color.at(u, v, 2) << 16);
  }
  frame_.color = ColorImage();
  live.prepare(frame_);
  EXPECT_EQ(live.color(), nullptr) << "a frame without colour keeps none of the last";
}

}  // namespace
}  // namespace plumbline
