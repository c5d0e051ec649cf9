#include "io/containers/rosbag.h"

#include <gmock/gmock.h>

#include "io/containers/ros_messages.h"
#include "plumbline/frame.h"
#include "plumbline/pinhole.h"
#include "plumbline/sequence.h"
#include "support/error_of.h"
#include "support/source.h"
#include "support/temp_folder.h"

namespace plumbline {
namespace {

using test::error_of;
using test::TempFolder;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

// Written by ROS's own rosbag; what they hold stands in make_bags.py.
std::string bag(const std::string& name) { return (test::source_root() / "tests/io/bags" / name).string(); }

SequenceOptions raw() {
  SequenceOptions options;
  options.intrinsics = Pinhole{30, 30, 15, 11, 0, 0};
  options.undistort = false;
  return options;
}

void expect_frames(const Sequence& sequence) {
  EXPECT_EQ(sequence.info().format, "ROS bag");
  ASSERT_EQ(sequence.size(), 3);
  EXPECT_EQ(sequence.info().color_frames, 3);
  for (const int k : {2, 0, 1}) {  // in any order
    const Frame frame = sequence.read(k);
    EXPECT_EQ(frame.time, 100'500'000'000 + k * 100'000'000);  // of the header, not of the recorder
    ASSERT_EQ(frame.depth.width, 32);
    ASSERT_EQ(frame.depth.height, 24);
    for (int y = 0; y < 24; ++y) {
      for (int x = 0; x < 32; ++x) {
        const auto i = static_cast<std::size_t>(32 * y + x);
        const double expected = i == 0 ? 0 : 1000 + 10 * x + y + 100 * k;
        ASSERT_NEAR(1000 * frame.depth.pixels[i] / frame.depth_scale, expected, 0.01) << x << ' ' << y << ' ' << k;
        ASSERT_EQ(frame.color.pixels[3 * i], x);
        ASSERT_EQ(frame.color.pixels[3 * i + 1], y);
        ASSERT_EQ(frame.color.pixels[3 * i + 2], 50 * k);
      }
    }
  }
}

TEST(RosBag, ReadsPlainChunks) {
  SequenceOptions options = raw();
  options.intrinsics.reset();
  const auto sequence = open_sequence(bag("plain.bag"), options);
  expect_frames(*sequence);
  const SequenceInfo& info = sequence->info();
  EXPECT_EQ(info.camera, (Pinhole{30, 31, 15.5f, 11.5f, 32, 24}));
  EXPECT_EQ(info.distortion, (Distortion{0.1, -0.2, 0.001, 0.002, 0.05}));
  EXPECT_EQ(info.camera_source, "the bag's /camera/depth/camera_info");
  EXPECT_EQ(info.depth_scale, 1000);
  EXPECT_THAT(info.notes, IsEmpty());
  const ImuRecording imu = sequence->read_imu();
  ASSERT_EQ(imu.samples.size(), 20U);
  EXPECT_TRUE(imu.has_gyroscope);
  EXPECT_DOUBLE_EQ(imu.samples[7].angular_rate.x(), 0.07);
  EXPECT_DOUBLE_EQ(imu.samples[7].specific_force.z(), 9.81);
  EXPECT_NE(open_sequence(bag("plain.bag"))->read(0).depth.pixels, sequence->read(0).depth.pixels);  // undistorted
}

TEST(RosBag, ReadsFloatsAndBz2AsTumHasThem) {
  SequenceOptions options = raw();
  options.intrinsics.reset();
  const auto sequence = open_sequence(bag("tum.bag"), options);
  expect_frames(*sequence);
  EXPECT_EQ(sequence->info().camera, (Pinhole{29, 29, 15, 11, 32, 24}));  // of the rectified image
  EXPECT_TRUE(sequence->info().distortion.is_zero());
  EXPECT_FALSE(sequence->read_imu().has_gyroscope);
}

TEST(RosBag, ReadsPackedImagesAndLz4) {
  const auto sequence = open_sequence(bag("packed.bag"), raw());
  expect_frames(*sequence);
  // No camera_info, and the Kinect's default cannot be meant: its images are larger.
  EXPECT_THAT(error_of([] { open_sequence(bag("packed.bag")); }), HasSubstr("no camera_info for its depth"));
}

TEST(RosBag, TakesTopicsByName) {
  SequenceOptions options = raw();
  options.depth_topic = "/camera/depth/image_raw";
  EXPECT_EQ(open_sequence(bag("plain.bag"), options)->size(), 3);
  options.depth_topic = "/camera/rgb/image_color";
  EXPECT_THAT(error_of([&] { open_sequence(bag("plain.bag"), options); }),
              AllOf(HasSubstr("no depth under '/camera/rgb/image_color'"),
                    HasSubstr("/camera/depth/image_raw (sensor_msgs/Image, 3 messages)")));
  options.depth_topic.clear();
  options.color = false;
  EXPECT_TRUE(open_sequence(bag("plain.bag"), options)->read(0).color.pixels.empty());
}

TEST(RosBag, ReadsWhatIsThereOfABagThatBrokeOff) {
  const TempFolder folder;
  for (const char* name : {"plain.bag", "tum.bag", "packed.bag"}) {
    const std::string bytes = test::read_text(bag(name));
    int opened = 0;
    for (std::size_t size = 0; size < bytes.size(); size += 509) {
      test::write_text(folder / "cut.bag", bytes.substr(0, size));
      try {
        const auto sequence = open_sequence(folder / "cut.bag", raw());
        ++opened;
        const int last = sequence->size() - 1;
        EXPECT_EQ(sequence->read(last).index, last);
        if (sequence->size() < 3) {
          EXPECT_THAT(sequence->info().notes, Contains(HasSubstr("ends early")));
        }
      } catch (const Error& error) {
        EXPECT_THAT(error.what(), HasSubstr("cut.bag"));
      }
    }
    EXPECT_GT(opened, 2) << name;
  }
}

TEST(RosBag, RefusesWhatIsNoBag) {
  const TempFolder folder;
  test::write_text(folder / "old.bag", "#ROSBAG V1.2\n");
  EXPECT_THAT(error_of([&] { open_sequence(folder / "old.bag"); }), HasSubstr("no recording that can be read"));
  std::string bytes = test::read_text(bag("tum.bag"));
  bytes[bytes.find("BZh") + 30] ^= 0x55;
  test::write_text(folder / "bad.bag", bytes);
  EXPECT_THAT(error_of([&] { open_sequence(folder / "bad.bag"); }), HasSubstr("bad.bag"));
}

TEST(RosMessages, RefuseImpossibleImages) {
  ros::Image image;
  image.encoding = "16UC1";
  image.width = 4, image.height = 2, image.step = 8;
  const std::string data("\x01\x02\x03\x04\x05\x06\x07\x08\x11\x12\x13\x14\x15\x16\x17\x18", 16);
  image.data = data;
  EXPECT_EQ(ros::depth_of(image, "x").pixels[1], 0x0403);
  image.big_endian = true;
  EXPECT_EQ(ros::depth_of(image, "x").pixels[1], 0x0304);
  image.data = std::string_view(data).substr(0, 15);
  EXPECT_THAT(error_of([&] { ros::depth_of(image, "x"); }), HasSubstr("holds fewer bytes"));
  image.data = data;
  image.step = 6;
  EXPECT_THAT(error_of([&] { ros::depth_of(image, "x"); }), HasSubstr("holds fewer bytes"));
  image.width = 0;
  EXPECT_THAT(error_of([&] { ros::depth_of(image, "x"); }), HasSubstr("impossible size"));
  image.encoding = "bayer_grbg16";
  EXPECT_THAT(error_of([&] { ros::color_of(image, "x"); }), HasSubstr("no colour that can be read"));
}

}  // namespace
}  // namespace plumbline
