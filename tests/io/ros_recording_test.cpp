#include <gmock/gmock.h>

#include <filesystem>

#include "io/containers/message_store.h"
#include "io/containers/ros_messages.h"
#include "io/images/png.h"
#include "io/recording.h"
#include "io/text_file.h"
#include "plumbline/frame.h"
#include "plumbline/pinhole.h"
#include "plumbline/sequence.h"
#include "support/error_of.h"
#include "support/ros_writer.h"
#include "support/temp_folder.h"

namespace plumbline {
namespace {

using namespace test;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr int kWidth = 16, kHeight = 12, kFrames = 3;
constexpr double kDepthFocal = 20, kColorFocal = 30;

Nanoseconds time_of(int k) { return 100 * kNanosecondsPerSecond + k * kNanosecondsPerSecond / 30; }

std::string depth_data(int k, bool big_endian = false) {
  std::string data;
  for (int i = 0; i < kWidth * kHeight; ++i) {
    std::string value = little(static_cast<std::uint16_t>(1000 + i + 100 * k));
    if (big_endian) std::swap(value[0], value[1]);
    data += value;
  }
  return data;
}

/// Every pixel tells where it stands.
std::string color_data(int width, int height) {
  std::string data;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) data += {static_cast<char>(8 * x), static_cast<char>(8 * y), 7};
  return data;
}

struct Topics {
  std::string prefix = "sensor_msgs/msg/";
  std::string depth = "/camera/depth/image_rect_raw", depth_info = "/camera/depth/camera_info";
  std::string color = "/camera/color/image_raw", color_info = "/camera/color/camera_info";
  std::string gyroscope = "/camera/gyro/sample", accelerometer = "/camera/accel/sample";
  std::string depth_encoding = "16UC1";
};

/// Depth and colour of two cameras, the infrared that stands beside them, and the sensors on topics apart.
std::vector<RecordedMessage> recording(Encoding e, const Topics& t = {}, double color_focal = kColorFocal) {
  std::vector<RecordedMessage> all = {{t.depth_info, t.prefix + "CameraInfo", time_of(0),
                                       camera_message(e, "depth", kWidth, kHeight, kDepthFocal, 7.5, 5.5)},
                                      {t.color_info, t.prefix + "CameraInfo", time_of(0),
                                       camera_message(e, "color", kWidth, kHeight, color_focal, 7.5, 5.5)}};
  for (int k = 0; k < kFrames; ++k) {
    all.push_back(
        {"/camera/infra1/image_rect_raw", t.prefix + "Image", time_of(k),
         image_message(e, time_of(k), "depth", kWidth, kHeight, "mono8", std::string(kWidth * kHeight, 'i'))});
    all.push_back({t.depth, t.prefix + "Image", time_of(k),
                   image_message(e, time_of(k), "depth", kWidth, kHeight, t.depth_encoding, depth_data(k))});
    all.push_back(
        {t.color, t.prefix + "Image", time_of(k),
         image_message(e, time_of(k) + 1'000'000, "color", kWidth, kHeight, "rgb8", color_data(kWidth, kHeight))});
  }
  for (int i = 0; i < 20; ++i) {
    const Nanoseconds time = time_of(0) + i * 5'000'000;
    all.push_back({t.gyroscope, t.prefix + "Imu", time, imu_message(e, time, "imu", {0.1 * i, 0, 1}, {0, 0, 0})});
    if (i % 4 == 0)
      all.push_back(
          {t.accelerometer, t.prefix + "Imu", time, imu_message(e, time, "imu", {0, 0, 0}, {0, -9.8, 0.1 * i})});
  }
  return all;
}

RecordedMessage mounting(Encoding e, const char* type = "tf2_msgs/msg/TFMessage") {
  // depth_from_color: the colour camera 5 cm to the right.
  return {"/tf_static", type, time_of(0), tf_message(e, "depth", "color", {0.05, 0, 0}, {0, 0, 0, 1})};
}

void expect_depth(const Sequence& sequence, double metres_per_reading = 1e-3) {
  ASSERT_EQ(sequence.size(), kFrames);
  EXPECT_EQ(sequence.info().camera, (Pinhole{20, 20, 7.5f, 5.5f, kWidth, kHeight}));
  for (const int k : {2, 0, 1}) {
    const Frame frame = sequence.read(k);
    EXPECT_EQ(frame.time, time_of(k));
    for (const int i : {0, 5, kWidth * kHeight - 1})
      EXPECT_NEAR(frame.depth.pixels[static_cast<std::size_t>(i)] / frame.depth_scale,
                  metres_per_reading * (1000 + i + 100 * k), 1e-6);
  }
}

/// Colour is that of the colour camera's pixel which sees the depth's point.
void expect_registered_color(const Sequence& sequence) {
  EXPECT_EQ(sequence.info().color_frames, kFrames);
  const Frame frame = sequence.read(1);
  const int x = 8, y = 6, i = y * kWidth + x;
  const double z = frame.depth.pixels[static_cast<std::size_t>(i)] / frame.depth_scale;
  const double px = (x - 7.5) / kDepthFocal * z - 0.05, py = (y - 5.5) / kDepthFocal * z;
  EXPECT_NEAR(frame.color.pixels[static_cast<std::size_t>(3 * i)], 8 * (kColorFocal * px / z + 7.5), 1);
  EXPECT_NEAR(frame.color.pixels[static_cast<std::size_t>(3 * i) + 1], 8 * (kColorFocal * py / z + 5.5), 1);
}

void expect_joined_imu(const Sequence& sequence) {
  std::vector<std::string> notes;
  const ImuRecording imu = sequence.read_imu(&notes);
  EXPECT_TRUE(imu.has_gyroscope);
  ASSERT_GE(imu.samples.size(), 17U);
  EXPECT_NEAR(imu.samples[6].angular_rate.x(), 0.6, 1e-12);
  EXPECT_NEAR(imu.samples[6].specific_force.z(), 0.6, 1e-12);  // between the readings of 4 and 8
  EXPECT_NEAR(imu.samples[6].specific_force.y(), -9.8, 1e-12);
  EXPECT_THAT(notes, Contains(HasSubstr("topics apart")));
  ASSERT_TRUE(sequence.info().body_from_camera);
  EXPECT_TRUE(sequence.info().body_from_camera->isIdentity());
}

std::vector<RecordedMessage> with(std::vector<RecordedMessage> all, RecordedMessage one) {
  all.push_back(std::move(one));
  return all;
}

TEST(RosRecording, ReadsMcapOfAnyPackingAndOrderOfBytes) {
  const TempFolder folder;
  for (const bool big_endian : {false, true}) {
    const Encoding e{true, big_endian};
    for (const char* packing : {"", "none", "lz4", "zstd"}) {
      write_text(folder / "scan.mcap", mcap_bytes(with(recording(e), mounting(e)), packing));
      const auto sequence = open_sequence(folder / "scan.mcap");
      EXPECT_EQ(sequence->info().format, "MCAP");
      EXPECT_EQ(sequence->info().camera_source, "the bag's /camera/depth/camera_info");
      expect_depth(*sequence);
      expect_registered_color(*sequence);
      expect_joined_imu(*sequence);
    }
  }
}

TEST(RosRecording, ReadsWhatIsThereOfAnMcapThatBrokeOff) {
  const TempFolder folder;
  const std::string bytes = mcap_bytes(recording({}), "none");
  int opened = 0;
  for (std::size_t size = 0; size < bytes.size(); size += 501) {
    write_text(folder / "cut.mcap", bytes.substr(0, size));
    try {
      const auto sequence = open_sequence(folder / "cut.mcap");
      sequence->read(sequence->size() - 1);
      ++opened;
      if (sequence->size() < kFrames) {
        EXPECT_THAT(sequence->info().notes, Contains(HasSubstr("ends early")));
      }
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("cut.mcap"));
    }
  }
  EXPECT_GT(opened, 2);
}

TEST(RosRecording, ReadsRos1MessagesInMcap) {
  const TempFolder folder;
  Topics topics;
  topics.prefix = "sensor_msgs/";
  write_text(folder / "scan.mcap", mcap_bytes(recording({false}, topics), "zstd", "ros1"));
  expect_depth(*open_sequence(folder / "scan.mcap"));
}

TEST(RosRecording, ReadsSqliteAndPackedMessages) {
  const TempFolder folder;
  std::vector<RecordedMessage> messages = with(recording({}), mounting({}));
  write_db3(folder / "scan.db3", messages);
  const auto sequence = open_sequence(folder / "scan.db3");
  EXPECT_EQ(sequence->info().format, "ROS 2 bag (SQLite)");
  expect_depth(*sequence);
  expect_registered_color(*sequence);
  expect_joined_imu(*sequence);
  for (RecordedMessage& message : messages) message.data = zstd_packed(message.data);
  write_db3(folder / "packed.db3", messages);
  expect_depth(*open_sequence(folder / "packed.db3"));
}

TEST(RosRecording, ReadsFoldersOfSeveralFiles) {
  const TempFolder folder;
  const std::vector<RecordedMessage> all = recording({});
  std::filesystem::create_directories(folder.path() / "bag");
  write_db3(folder / "bag/bag_0.db3", {all.begin(), all.begin() + 6});
  write_db3(folder / "bag/bag_1.db3", {all.begin() + 6, all.end()});
  write_text(folder.path() / "bag/metadata.yaml",
             "rosbag2_bagfile_information:\n  relative_file_paths:\n    - bag_0.db3\n    - bag_1.db3\n  version: 5\n");
  expect_depth(*open_sequence(folder / "bag"));
  std::filesystem::remove(folder.path() / "bag/bag_1.db3");
  EXPECT_THAT(open_sequence(folder / "bag")->info().notes, Contains(HasSubstr("bag_1.db3, which metadata.yaml lists")));
  std::filesystem::remove(folder.path() / "bag/bag_0.db3");
  EXPECT_THAT(error_of([&] { open_sequence(folder / "bag"); }), HasSubstr("none of the files of a ROS 2 recording"));
}

TEST(RosRecording, LeavesOutColourOfACameraWhosePlaceIsUnknown) {
  const TempFolder folder;
  Topics topics;
  topics.prefix = "sensor_msgs/";
  write_text(folder / "scan.bag", bag_bytes(recording({false}, topics)));
  const auto sequence = open_sequence(folder / "scan.bag");
  expect_depth(*sequence);
  EXPECT_EQ(sequence->info().color_frames, 0);
  EXPECT_THAT(sequence->info().notes,
              Contains(AllOf(HasSubstr("colour (/camera/color/image_raw): not used, because it is another camera's"),
                             HasSubstr("no extrinsics"))));
  write_text(folder / "scan.bag", bag_bytes(with(recording({false}, topics), mounting({false}, "tf2_msgs/TFMessage"))));
  expect_registered_color(*open_sequence(folder / "scan.bag"));
  topics.depth = "/camera/aligned_depth_to_color/image_raw";
  topics.depth_info = "/camera/aligned_depth_to_color/camera_info";
  write_text(folder / "scan.bag", bag_bytes(recording({false}, topics)));
  const auto aligned = open_sequence(folder / "scan.bag");
  EXPECT_EQ(aligned->read(0).color.pixels[3], 8);  // as it is
  EXPECT_THAT(aligned->info().notes, IsEmpty());
}

TEST(RosRecording, EqualIntrinsicsOfAnotherDeviceAreNoRegistration) {
  const TempFolder folder;
  Topics topics;
  topics.color = "/other/color/image_raw";
  topics.color_info = "/other/color/camera_info";
  write_db3(folder / "scan.db3", recording({}, topics, kDepthFocal));
  const auto other = open_sequence(folder / "scan.db3");
  EXPECT_EQ(other->info().color_frames, 0);
  EXPECT_THAT(other->info().notes, Contains(HasSubstr("in another frame than depth (color and depth)")));
  topics = {};
  std::filesystem::remove(folder.path() / "scan.db3");
  write_db3(folder / "scan.db3", recording({}, topics, kDepthFocal));
  const auto same = open_sequence(folder / "scan.db3");
  EXPECT_EQ(same->info().color_frames, kFrames);
  EXPECT_THAT(same->info().notes, Contains(HasSubstr("taken for registered, a guess")));
}

TEST(RosRecording, SaysWhatIsWrongWithTheCameraInfos) {
  const TempFolder folder;
  const Encoding e;
  std::vector<RecordedMessage> all = {{"/camera/depth/camera_info", "sensor_msgs/msg/CameraInfo", time_of(0),
                                       camera_message(e, "depth", kWidth, kHeight, 0, 0, 0)}};
  for (int k = 0; k < kFrames; ++k)
    all.push_back({"/camera/depth/image", "sensor_msgs/msg/Image", time_of(k),
                   image_message(e, time_of(k), "depth", kWidth, kHeight, "16UC1", depth_data(k))});
  write_db3(folder / "zero.db3", all);
  EXPECT_THAT(error_of([&] { open_sequence(folder / "zero.db3"); }),
              AllOf(HasSubstr("not calibrated: its matrix K is zero"), HasSubstr("--intrinsics")));
  all.front().data = camera_message(e, "depth", 2 * kWidth, 2 * kHeight, 2 * kDepthFocal, 15.5, 11.5);
  write_db3(folder / "large.db3", all);
  const auto scaled = open_sequence(folder / "large.db3");
  EXPECT_EQ(scaled->info().camera, (Pinhole{20, 20, 7.5f, 5.5f, kWidth, kHeight}));
  EXPECT_THAT(scaled->info().camera_source, HasSubstr("scaled from 32x24"));
}

TEST(RosRecording, ColourOnAnotherClockIsTold) {
  const TempFolder folder;
  std::vector<RecordedMessage> all = recording({}, {}, kDepthFocal);
  for (RecordedMessage& message : all)
    if (message.topic == "/camera/color/image_raw")
      message.data = image_message({}, message.time - 50 * kNanosecondsPerSecond, "depth", kWidth, kHeight, "rgb8",
                                   color_data(kWidth, kHeight));
  write_db3(folder / "scan.db3", all);
  EXPECT_THAT(open_sequence(folder / "scan.db3")->info().notes,
              Contains(AllOf(HasSubstr("colour is not used, because 3 of 3"), HasSubstr("50.000"))));
}

TEST(RosRecording, RealNumbersOfMillimetresAndPackedDepth) {
  const TempFolder folder;
  const Encoding e;
  std::string millimetres;
  for (int i = 0; i < kWidth * kHeight; ++i) millimetres += little(static_cast<float>(1500 + i));
  write_db3(folder / "mm.db3", {{"/camera/depth/camera_info", "sensor_msgs/msg/CameraInfo", time_of(0),
                                 camera_message(e, "depth", kWidth, kHeight, kDepthFocal, 7.5, 5.5)},
                                {"/camera/depth/image", "sensor_msgs/msg/Image", time_of(0),
                                 image_message(e, time_of(0), "depth", kWidth, kHeight, "32FC1", millimetres)}});
  EXPECT_THAT(open_sequence(folder / "mm.db3")->info().warnings.front().what, HasSubstr("seem to be millimetres"));
  SequenceOptions options;
  options.depth_scale = 1000;
  const Frame frame = open_sequence(folder / "mm.db3", options)->read(0);
  EXPECT_NEAR(frame.depth.pixels[5] / frame.depth_scale, 1.505, 2e-4) << "the scale that is given counts";

  DepthImage depth(kWidth, kHeight);
  std::fill(depth.pixels.begin(), depth.pixels.end(), std::uint16_t{1234});
  write_depth_png(folder / "d.png", depth);
  const std::string packed =
      RosMessage(e).header(time_of(0), "depth").text("16UC1; png compressed").data(read_file(folder / "d.png")).bytes();
  write_db3(folder / "png.db3",
            {{"/camera/depth/camera_info", "sensor_msgs/msg/CameraInfo", time_of(0),
              camera_message(e, "depth", kWidth, kHeight, kDepthFocal, 7.5, 5.5)},
             {"/camera/depth/image/compressed", "sensor_msgs/msg/CompressedImage", time_of(0), packed}});
  EXPECT_EQ(open_sequence(folder / "png.db3")->read(0).depth.pixels[9], 1234);
}

TEST(RosRecording, ReadsRealSenseRecordings) {
  const TempFolder folder;
  const Encoding e{false};
  const std::string device = "/device_0/sensor_";
  Topics topics{"sensor_msgs/",
                device + "0/Depth_0/image/data",
                device + "0/Depth_0/info/camera_info",
                device + "1/Color_0/image/data",
                device + "1/Color_0/info/camera_info",
                device + "2/Gyro_0/imu/data",
                device + "2/Accel_0/imu/data",
                "mono16"};
  std::vector<RecordedMessage> all = recording(e, topics);
  all.push_back(
      {device + "0/option/Depth Units/value", "std_msgs/Float32", time_of(0), RosMessage(e).add(0.00025f).bytes()});
  const auto stream = [&](const std::string& name, double x) {
    all.push_back(
        {name + "/tf/0", "geometry_msgs/Transform", time_of(0), RosMessage(e).doubles({x, 0, 0, 0, 0, 0, 1}).bytes()});
  };
  stream(device + "0/Depth_0", 0);
  stream(device + "1/Color_0", -0.05);
  stream(device + "2/Gyro_0", 0);
  write_text(folder / "scan.bag", bag_bytes(all));
  const auto sequence = open_sequence(folder / "scan.bag");
  EXPECT_EQ(sequence->info().format, "RealSense recording");
  EXPECT_EQ(sequence->info().depth_scale, 4000);
  EXPECT_THAT(sequence->info().depth_scale_source, HasSubstr("Depth Units"));
  expect_depth(*sequence, 0.25e-3);
  EXPECT_EQ(sequence->info().color_frames, kFrames);
  EXPECT_THAT(sequence->info().notes, Contains(HasSubstr("Color_0/image/data) is brought to depth")));
  expect_joined_imu(*sequence);
}

TEST(RosRecording, InvertsLibrealsensesModel) {
  const std::string message =
      camera_message({false}, "c", 640, 480, 600, 320, 240, "Inverse Brown Conrady", {0.1, -0.05, 0.001, -0.002, 0.01});
  const ros::CameraInfo info = ros::parse_camera_info(message, Wire::ros1, "x");
  // A distorted position, undistorted as librealsense does, must come back.
  const double x = 0.3, y = -0.2, r = x * x + y * y, radial = 1 + 0.1 * r - 0.05 * r * r + 0.01 * r * r * r;
  const double ux = x * radial + 2 * 0.001 * x * y - 0.002 * (r + 2 * x * x);
  const double uy = y * radial + 2 * -0.002 * x * y + 0.001 * (r + 2 * y * y);
  double dx = 0, dy = 0;
  info.distortion.apply(ux, uy, &dx, &dy);
  EXPECT_NEAR(dx, x, 2e-4);
  EXPECT_NEAR(dy, y, 2e-4);
}

TEST(RosRecording, RefusesDamagedMessagesAndOtherDatabases) {
  const TempFolder folder;
  EXPECT_THAT(error_of([] { ros::parse_stamp(std::string("\0\x03\0\0", 4), Wire::cdr, "x"); }), HasSubstr("CDR"));
  EXPECT_THAT(error_of([] { ros::parse_stamp(std::string("\0\1\0\0\1\0", 6), Wire::cdr, "x"); }), HasSubstr("cut off"));
  sqlite3* db = nullptr;
  sqlite3_open((folder / "other.db3").c_str(), &db);
  sqlite3_exec(db, "CREATE TABLE topics(id INTEGER)", nullptr, nullptr, nullptr);
  sqlite3_close(db);
  EXPECT_THAT(error_of([&] { open_sequence(folder / "other.db3"); }), HasSubstr("none of ROS 2"));
  write_db3(folder / "imu.db3", {{"/imu", "sensor_msgs/msg/Imu", 1, imu_message({}, 1, "i", {0, 0, 0}, {0, 0, 9})}});
  EXPECT_THAT(error_of([&] { open_sequence(folder / "imu.db3"); }),
              AllOf(HasSubstr("no topic with depth images"), HasSubstr("/imu (sensor_msgs/Imu, 1 messages)")));
}

/// The encoder of Wilson 2017, as compressed_depth_image_transport has it.
std::string rvl(const std::vector<std::uint16_t>& readings) {
  std::vector<std::uint32_t> nibbles;
  const auto put = [&](std::uint32_t value) {
    do {
      const std::uint32_t nibble = value & 7;
      value >>= 3;
      nibbles.push_back(value != 0 ? nibble | 8 : nibble);
    } while (value != 0);
  };
  int previous = 0;
  for (std::size_t i = 0; i < readings.size();) {
    std::size_t values = i;
    while (values < readings.size() && readings[values] == 0) ++values;
    std::size_t end = values;
    while (end < readings.size() && readings[end] != 0) ++end;
    put(static_cast<std::uint32_t>(values - i));
    put(static_cast<std::uint32_t>(end - values));
    for (i = values; i < end; ++i) {
      const int delta = readings[i] - previous;
      put(static_cast<std::uint32_t>((delta << 1) ^ (delta >> 31)));
      previous = readings[i];
    }
  }
  std::string bytes;
  for (std::size_t i = 0; i < nibbles.size(); i += 8) {
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 8; ++k) word = word << 4 | (i + k < nibbles.size() ? nibbles[i + k] : 0);
    bytes += little(word);
  }
  return bytes;
}

TEST(RosRecording, ReadsDepthPackedByRvl) {
  std::vector<std::uint16_t> readings(static_cast<std::size_t>(kWidth * kHeight));
  for (std::size_t i = 0; i < readings.size(); ++i)
    readings[i] = static_cast<std::uint16_t>(i % 7 == 0 || i < 20 ? 0 : 1000 + 37 * i % 4001);
  readings[30] = 65535;
  const std::string data =
      std::string(12, '\0') + little(std::uint32_t{kWidth}) + little(std::uint32_t{kHeight}) + rvl(readings);
  const auto image_of = [&](const std::string& bytes) {
    const std::string message =
        RosMessage({false}).header(time_of(0), "depth").text("16UC1; compressedDepth rvl").data(bytes).bytes();
    return ros::depth_of(ros::parse_image(message, Wire::ros1, true, "x"), "x");
  };
  EXPECT_EQ(image_of(data).width, kWidth);
  EXPECT_EQ(image_of(data).pixels, readings);
  EXPECT_THAT(error_of([&] { image_of(data.substr(0, data.size() - 8)); }), HasSubstr("cut off"));
  EXPECT_THAT(error_of([&] { image_of(data.substr(0, 14)); }), HasSubstr("cut off"));
}

ColorImage color_of(const std::string& encoding, int width, int height, const std::string& data) {
  const std::string message = image_message({false}, time_of(0), "c", width, height, encoding, data);
  return ros::color_of(ros::parse_image(message, Wire::ros1, false, "x"), "x");
}

TEST(RosRecording, ReadsYuv) {
  // Red and white of BT.601, two pixels with one chroma.
  const std::string red = "\x52\x5a\x52\xf0", uyvy = "\x5a\x52\xf0\xeb";
  const ColorImage a = color_of("yuv422_yuy2", 2, 1, red);
  EXPECT_NEAR(a.at(0, 0, 0), 255, 2);
  EXPECT_NEAR(a.at(1, 0, 1), 0, 2);
  EXPECT_NEAR(a.at(1, 0, 2), 0, 2);
  const ColorImage b = color_of("yuv422", 2, 1, uyvy);
  EXPECT_EQ(b.at(0, 0, 0), a.at(0, 0, 0));
  EXPECT_GT(b.at(1, 0, 1), 100) << "the second pixel's own luma";
  EXPECT_THAT(error_of([] { color_of("yuv422", 3, 1, "abcdef"); }), HasSubstr("odd width"));
}

TEST(RosRecording, ReadsBayer) {
  // A plain of (200, 100, 50) behind each of the four filters.
  for (const auto& [encoding, tile] :
       {std::pair("bayer_rggb8", "RGGB"), {"bayer_bggr8", "BGGR"}, {"bayer_gbrg8", "GBRG"}, {"bayer_grbg8", "GRBG"}}) {
    std::string data;
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 8; ++x) {
        const char filter = tile[2 * (y % 2) + x % 2];
        data += static_cast<char>(filter == 'R' ? 200 : filter == 'G' ? 100 : 50);
      }
    const ColorImage color = color_of(encoding, 8, 6, data);
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 8; ++x) {
        EXPECT_EQ(color.at(x, y, 0), 200) << encoding << x << y;
        EXPECT_EQ(color.at(x, y, 1), 100) << encoding << x << y;
        EXPECT_EQ(color.at(x, y, 2), 50) << encoding << x << y;
      }
  }
}

}  // namespace
}  // namespace plumbline
