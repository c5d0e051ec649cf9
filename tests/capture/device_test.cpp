// Depth devices and the thread that fetches from them.
#include "capture/depth_device.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "capture/clock.h"
#include "capture/color_pairing.h"
#include "capture/frame_grabber.h"
#include "io/images/png.h"
#include "plumbline/error.h"
#include "plumbline/image.h"
#include "plumbline/time.h"
#include "support/error_of.h"
#include "support/temp_folder.h"

namespace plumbline::capture {
namespace {

using std::chrono::milliseconds;
using test::TempFolder;
using testing::AllOf;
using testing::HasSubstr;

constexpr Nanoseconds kMs = 1'000'000;

/// A folder of `frames` tiny images, 20 ms apart; the readings of image i are i + 1.
std::string tiny_sequence(const TempFolder& folder, int frames) {
  std::string list;
  for (int i = 0; i < frames; ++i) {
    DepthImage image(32, 24);
    for (std::uint16_t& reading : image.pixels) reading = static_cast<std::uint16_t>(i + 1);
    const std::string name = fmt::format("depth/{}.png", i);
    std::filesystem::create_directories(folder.path() / "tiny" / "depth");
    write_depth_png(folder / ("tiny/" + name), image);
    list += fmt::format("{} {}\n", format_seconds(7 * kNanosecondsPerSecond + 20 * kMs * i), name);
  }
  test::write_text(folder.path() / "tiny" / "depth.txt", list);
  test::write_text(folder.path() / "tiny" / "camera-intrinsics.txt", "30 0 15.5\n0 30 11.5\n0 0 1\n");
  return folder / "tiny";
}

FrameGrabber::Open opens(const std::string& folder, double speed) {
  return [=] { return open_depth_device({.device = "virtual:" + folder, .speed = speed}); };
}

std::vector<CapturedFrame> all_frames(FrameGrabber& grabber, milliseconds pause = milliseconds(0)) {
  std::vector<CapturedFrame> frames;
  while (!grabber.status().ended) {
    if (auto frame = grabber.next(milliseconds(1000))) frames.push_back(std::move(*frame));
    std::this_thread::sleep_for(pause);
  }
  return frames;
}

TEST(VirtualDevice, WithoutAPauseEveryFrameComesInOrder) {
  const TempFolder folder;
  FrameGrabber grabber(opens(tiny_sequence(folder, 40), 0), 2);
  EXPECT_EQ(grabber.info().camera.fx, 30);
  EXPECT_EQ(grabber.info().depth_scale, 5000);
  const std::vector<CapturedFrame> frames = all_frames(grabber, milliseconds(1));
  ASSERT_EQ(frames.size(), 40u);
  for (int i = 0; i < 40; ++i) {
    EXPECT_EQ(frames[i].depth.at(3, 3), i + 1);
    EXPECT_EQ(frames[i].time - frames[0].time, 20 * kMs * i);
  }
  EXPECT_EQ(grabber.status().dropped, 0u);
}

TEST(VirtualDevice, InRealTimeNoFrameComesBeforeItsTime) {
  const TempFolder folder;
  FrameGrabber grabber(opens(tiny_sequence(folder, 20), 1), 30);
  const Nanoseconds begin = now();
  const std::vector<CapturedFrame> frames = all_frames(grabber);
  EXPECT_GE(now() - begin, 19 * 20 * kMs - 5 * kMs);
  for (const CapturedFrame& frame : frames) EXPECT_LE(frame.time, now());
  EXPECT_EQ(frames.size() + grabber.status().dropped, 20u);
  EXPECT_EQ(frames.back().depth.at(0, 0), 20);
}

TEST(FrameGrabber, AReaderThatIsSlowGetsTheLatestFrameAndTheOthersAreCounted) {
  const TempFolder folder;
  FrameGrabber grabber(opens(tiny_sequence(folder, 40), 1), 1);
  const std::vector<CapturedFrame> frames = all_frames(grabber, milliseconds(90));
  EXPECT_LT(frames.size(), 20u);
  EXPECT_GT(grabber.status().dropped, 15u);
  EXPECT_EQ(frames.size() + grabber.status().dropped, 40u);
  EXPECT_EQ(frames.back().depth.at(0, 0), 40);
}

/// Gives two frames, then falls silent, then comes back or breaks.
class MoodyDevice : public DepthDevice {
 public:
  MoodyDevice(std::atomic<bool>* silent, bool breaks) : silent_(silent), breaks_(breaks) {
    info_.camera = {30, 30, 15.5f, 11.5f, 32, 24};
  }
  std::optional<CapturedFrame> wait(milliseconds timeout) override {
    if (count_ == 2 && breaks_) throw Error("the camera was unplugged", "moody", "plug it in");
    if (count_ >= 2 && *silent_) {
      std::this_thread::sleep_for(timeout);
      return std::nullopt;
    }
    std::this_thread::sleep_for(milliseconds(5));
    ++count_;
    return CapturedFrame{now(), DepthImage(32, 24), 0, {}};
  }

 private:
  std::atomic<bool>* silent_;
  bool breaks_;
  int count_ = 0;
};

TEST(FrameGrabber, AStallShowsInTheStatusAndEnds) {
  std::atomic<bool> silent = true;
  FrameGrabber grabber([&] { return std::make_unique<MoodyDevice>(&silent, false); }, 4);
  EXPECT_TRUE(grabber.next(milliseconds(5000)));
  EXPECT_TRUE(grabber.next(milliseconds(5000)));
  EXPECT_FALSE(grabber.next(milliseconds(300)));
  EXPECT_GT(grabber.status().silence, 0.25);
  EXPECT_FALSE(grabber.status().ended);
  silent = false;
  EXPECT_TRUE(grabber.next(milliseconds(5000)));
}

TEST(FrameGrabber, ACameraThatIsUnpluggedIsToldAfterItsLastFrame) {
  std::atomic<bool> silent = false;
  FrameGrabber grabber([&] { return std::make_unique<MoodyDevice>(&silent, true); }, 4);
  EXPECT_TRUE(grabber.next(milliseconds(5000)));
  EXPECT_TRUE(grabber.next(milliseconds(5000)));
  EXPECT_THAT(test::error_of([&] { grabber.next(milliseconds(5000)); }), HasSubstr("unplugged"));
}

TEST(FrameGrabber, WhatCannotBeOpenedIsToldAtOnce) {
  EXPECT_THAT(test::error_of([] { FrameGrabber(opens("/nowhere", 1), 1); }), HasSubstr("/nowhere"));
  EXPECT_THAT(test::error_of([] { open_depth_device({.device = "webcam"}); }),
              AllOf(HasSubstr("'webcam'"), HasSubstr("openni2")));
  EXPECT_THAT(test::error_of([] { open_depth_device({.device = "virtual:"}); }), HasSubstr("virtual:DIR"));
}

// Without hardware these end in a message, whether the libraries were found or not.
TEST(DepthDevice, CamerasThatAreNotThere) {
#if !defined(__SANITIZE_ADDRESS__)  // OpenNI's drivers leak
  EXPECT_THAT(test::error_of([] { open_depth_device({.device = "openni2"}); }), HasSubstr("openni2"));
#endif
  EXPECT_THAT(test::error_of([] { open_depth_device({.device = "freenect"}); }), HasSubstr("freenect"));
  EXPECT_THAT(test::error_of([] { open_depth_device({.device = "freenect:left"}); }), HasSubstr("freenect"));
}

TEST(ColorPairing, JoinsTheNearestInEitherOrder) {
  ColorPairing pairing(true);
  pairing.add_color(100 * kMs, ColorImage(1, 1, 3));
  EXPECT_FALSE(pairing.take());
  pairing.add_depth(105 * kMs, DepthImage(1, 1));  // colour came first
  auto frame = pairing.take();
  ASSERT_TRUE(frame && !frame->color.empty());
  EXPECT_EQ(frame->color_time, 100 * kMs);
  pairing.add_depth(138 * kMs, DepthImage(1, 1));
  EXPECT_FALSE(pairing.take());
  pairing.add_color(141 * kMs, ColorImage(1, 1, 3));  // depth came first
  frame = pairing.take();
  ASSERT_TRUE(frame && !frame->color.empty());
  EXPECT_EQ(frame->time, 138 * kMs);
}

TEST(ColorPairing, DepthNeverWaitsForLongerThanAFrame) {
  ColorPairing pairing(true);
  pairing.add_color(0, ColorImage(1, 1, 3));
  pairing.add_depth(30 * kMs, DepthImage(1, 1));  // too far from that colour
  EXPECT_FALSE(pairing.take());
  pairing.add_depth(63 * kMs, DepthImage(1, 1));
  const auto frame = pairing.take();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->time, 30 * kMs);
  EXPECT_TRUE(frame->color.empty());
  ColorPairing alone(false);
  alone.add_depth(1, DepthImage(1, 1));
  EXPECT_TRUE(alone.take());
}

TEST(DepthScale, IsConvertedWithRoundingAndWithoutWrapping) {
  DepthImage image(4, 1);
  image.pixels = {0, 1001, 13107, 13108};  // millimetres; 13.107 m is the most that TUM's scale has
  EXPECT_EQ(at_scale(image, 1000, 5000).pixels, (std::vector<std::uint16_t>{0, 5005, 65535, 0}));
  EXPECT_EQ(at_scale(image, 2000, 1000).pixels[1], 501);
}

}  // namespace
}  // namespace plumbline::capture
