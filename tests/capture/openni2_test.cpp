// The driver of OpenNI 2 on the device that the library brings for tests: a depth camera without hardware.
#include <OpenNI.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "capture/clock.h"
#include "capture/frame_grabber.h"
#include "plumbline/time.h"
#include "support/error_of.h"
#include "support/temp_folder.h"

namespace plumbline::capture {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;

TEST(OpenNi2, DeliversDepthFromALiveDevice) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "OpenNI's drivers leak";
#endif
  // Once more than needed: the library must stay, as the test device's thread outlives the device.
  ASSERT_EQ(openni::OpenNI::initialize(), openni::STATUS_OK);
  std::unique_ptr<FrameGrabber> camera;
  try {
    camera = std::make_unique<FrameGrabber>([] { return open_depth_device({.device = "openni2:Dummy"}); }, 8);
  } catch (const Error& error) {
    GTEST_SKIP() << "OpenNI's test device is not installed: " << error.what();
  }
  const DepthDeviceInfo& info = camera->info();
  EXPECT_EQ(info.depth_scale, 1000);
  EXPECT_FALSE(info.has_color);
  EXPECT_EQ(info.camera.width, 320);
  EXPECT_NEAR(info.camera.fx, 277, 20);  // half a Kinect's
  const Nanoseconds begin = now();
  Nanoseconds last = 0;
  for (int i = 0; i < 10; ++i) {
    const auto frame = camera->next(milliseconds(5000));
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->depth.width, 320);
    EXPECT_EQ(frame->depth.height, 240);
    EXPECT_GT(*std::max_element(frame->depth.pixels.begin(), frame->depth.pixels.end()), 0);
    EXPECT_GT(frame->time, last);
    EXPECT_LE(frame->time, now());
    EXPECT_GT(frame->time, begin - kNanosecondsPerSecond);
    last = frame->time;
  }
}

TEST(OpenNi2, WhatCannotBeOpenedIsTold) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "OpenNI's drivers leak";
#endif
  const test::TempFolder folder;
  test::write_text(folder.path() / "no.oni", "this is no recording");
  EXPECT_THAT(test::error_of([&] { open_depth_device({.device = "openni2:" + (folder / "no.oni")}); }),
              HasSubstr("cannot be opened"));
  EXPECT_THAT(test::error_of([] { open_depth_device({.device = "openni2:none"}); }), HasSubstr("openni2"));
}

}  // namespace
}  // namespace plumbline::capture
