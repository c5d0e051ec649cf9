#include <gmock/gmock.h>

#include <cmath>

#include "io/containers/kinect_calibration.h"
#include "io/containers/matroska.h"
#include "io/images/jpeg.h"
#include "io/registration.h"
#include "plumbline/frame.h"
#include "plumbline/image.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "plumbline/sequence.h"
#include "support/data.h"
#include "support/error_of.h"
#include "support/temp_folder.h"

namespace plumbline {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::error_of;
using test::TempFolder;
using testing::Contains;
using testing::HasSubstr;

#define RECORDING_OR_SKIP(variable)                                    \
  PLUMBLINE_DATA_OR_SKIP(variable##_path, "recordings/recording.mkv"); \
  const std::string variable = variable##_path.string()

TEST(Kinect, ReadsARecording) {
  RECORDING_OR_SKIP(path);
  const auto sequence = open_sequence(path);
  const SequenceInfo& info = sequence->info();
  EXPECT_EQ(info.format, "Azure Kinect recording");
  EXPECT_EQ(info.frames, 1);
  EXPECT_EQ(info.color_frames, 1);
  EXPECT_EQ(info.depth_scale, 1000);
  EXPECT_EQ(info.camera_source, "the recording's calibration");
  // By hand from calibration.json: 1024 times the unit values, less the window's corner and half a pixel.
  EXPECT_NEAR(info.camera.fx, 0.4927808940410614 * 1024, 1e-3);
  EXPECT_NEAR(info.camera.fy, 0.49290284514427185 * 1024, 1e-3);
  EXPECT_NEAR(info.camera.cx, 0.51296979188919067 * 1024 - 192 - 0.5, 1e-3);
  EXPECT_NEAR(info.camera.cy, 0.51692354679107666 * 1024 - 180 - 0.5, 1e-3);
  EXPECT_EQ(info.camera.width, 640);
  EXPECT_EQ(info.camera.height, 576);
  EXPECT_DOUBLE_EQ(info.distortion.k4, 0.88967907428741455);
  EXPECT_DOUBLE_EQ(info.distortion.p1, 2.0557534298859537e-5);
  // The block's time, 463.945 ms, on the device's clock, which the tags put 336.277 ms further.
  EXPECT_EQ(sequence->time(0), 463'945'000 + 336'277'000);
}

TEST(Kinect, ReadsDepthAndColor) {
  RECORDING_OR_SKIP(path);
  SequenceOptions raw;
  raw.undistort = false;
  const Frame frame = open_sequence(path, raw)->read(0);
  // The bytes of two readings, most significant first, as a hexadecimal editor shows them in the file's DEPTH block.
  std::string bytes = test::read_text(path);
  const std::size_t block = bytes.find(std::string("\x82\x00\x00\x80", 4));  // track 2, at the cluster's time, key
  ASSERT_NE(block, std::string::npos);
  const auto at = [&](std::size_t i) { return static_cast<unsigned char>(bytes[block + 4 + i]); };
  int valid = 0;
  for (std::size_t i = 0; i < frame.depth.pixels.size(); ++i) {
    ASSERT_EQ(frame.depth.pixels[i], at(2 * i) << 8 | at(2 * i + 1)) << i;
    valid += frame.depth.pixels[i] > 0 ? 1 : 0;
  }
  EXPECT_GT(valid, 100'000);
  EXPECT_EQ(frame.color.width, 640);
  EXPECT_EQ(frame.color.height, 576);
  for (std::size_t i = 0; i < frame.depth.pixels.size(); ++i)  // colour only where there is a point to look up
    ASSERT_TRUE(frame.depth.pixels[i] > 0 ||
                (frame.color.pixels[3 * i] | frame.color.pixels[3 * i + 1] | frame.color.pixels[3 * i + 2]) == 0);
}

TEST(Kinect, ReadsTheImu) {
  RECORDING_OR_SKIP(path);
  const auto sequence = open_sequence(path);
  const ImuRecording imu = sequence->read_imu();
  ASSERT_EQ(imu.samples.size(), 1U);
  EXPECT_EQ(imu.samples[0].time, 336'277'000);
  EXPECT_NEAR(imu.samples[0].specific_force.norm(), 9.9, 0.3);
  EXPECT_LT(imu.samples[0].specific_force.z(), -9);  // the sensor's z axis points down
  EXPECT_LT(imu.samples[0].angular_rate.norm(), 0.05);
  ASSERT_TRUE(sequence->info().body_from_camera);
  const Matrix3d& body_from_camera = *sequence->info().body_from_camera;
  // Microsoft's drawing: the IMU's x axis points back, y left, z down; the depth camera is tilted by 6 degrees.
  EXPECT_LT((body_from_camera * Vector3d::UnitZ() - Vector3d(-1, 0, 0)).norm(), 0.15);
  EXPECT_LT((body_from_camera * Vector3d::UnitX() - Vector3d(0, -1, 0)).norm(), 0.15);
}

TEST(Kinect, UndistortsAsTheRationalModelSays) {
  RECORDING_OR_SKIP(path);
  const auto sequence = open_sequence(path);
  const Distortion& d = sequence->info().distortion;
  const double x = 0.4, y = -0.3, r2 = x * x + y * y;
  double u = 0, v = 0;
  d.apply(x, y, &u, &v);
  const double radial =
      (1 + d.k1 * r2 + d.k2 * r2 * r2 + d.k3 * r2 * r2 * r2) / (1 + d.k4 * r2 + d.k5 * r2 * r2 + d.k6 * r2 * r2 * r2);
  EXPECT_NEAR(u, x * radial + 2 * d.p1 * x * y + d.p2 * (r2 + 2 * x * x), 1e-12);
  EXPECT_NEAR(v, y * radial + 2 * d.p2 * x * y + d.p1 * (r2 + 2 * y * y), 1e-12);
  EXPECT_LT(radial, 0.99);  // the division matters: without it, radial would be above 1
  EXPECT_NE(sequence->read(0).depth.pixels, [&] {
    SequenceOptions raw;
    raw.undistort = false;
    return open_sequence(path, raw)->read(0).depth.pixels;
  }());
}

TEST(Kinect, SurvivesRecordingsThatBreakOff) {
  RECORDING_OR_SKIP(path);
  const TempFolder folder;
  const std::string bytes = test::read_text(path);
  test::write_text(folder / "imu.mkv", bytes.substr(0, 7700));  // before the frames: only the IMU's first block
  EXPECT_THAT(error_of([&] { open_sequence(folder / "imu.mkv"); }), HasSubstr("no depth frames"));
  test::write_text(folder / "cut.mkv", bytes.substr(0, bytes.size() - 400'000));  // within the IR image, after depth
  const auto sequence = open_sequence(folder / "cut.mkv");
  EXPECT_EQ(sequence->size(), 1);
  EXPECT_THAT(sequence->info().notes, Contains(HasSubstr("ends early")));
  EXPECT_EQ(sequence->read(0).depth.width, 640);
  test::write_text(folder / "head.mkv", bytes.substr(0, 60));
  EXPECT_THAT(error_of([&] { open_sequence(folder / "head.mkv"); }), HasSubstr("head.mkv"));
  test::write_text(folder / "other.mkv", "something else");
  EXPECT_THAT(error_of([&] { open_sequence(folder / "other.mkv"); }), HasSubstr("no recording that can be read"));
}

TEST(Kinect, RefusesCalibrationsThatItDoesNotKnow) {
  PLUMBLINE_DATA_OR_SKIP(path, "recordings/calibration.json");
  const std::string json = test::read_text(path);
  const auto parse = [](const std::string& text, const char* mode = "NFOV_UNBINNED", int width = 640) {
    return parse_kinect_calibration(text, mode, width, width * 9 / 10, 0, 0, "x.mkv");
  };
  EXPECT_EQ(parse(json).depth.width, 640);
  const KinectCalibration binned = parse(json, "NFOV_2X2BINNED", 320);
  EXPECT_NEAR(binned.depth.fx, parse(json).depth.fx / 2, 1e-3);
  EXPECT_NEAR((binned.depth.cx + 0.5f) * 2, parse(json).depth.cx + 0.5f, 1e-3);  // one camera, pixels twice as large
  EXPECT_THAT(error_of([&] { parse(json, "SOMETHING"); }), HasSubstr("depth mode 'SOMETHING' is not known"));
  EXPECT_THAT(error_of([&] { parse(json, "NFOV_UNBINNED", 320); }), HasSubstr("320x288"));
  EXPECT_THAT(error_of([&] { parse("{}"); }), HasSubstr("x.mkv: the attached calibration cannot be read"));
  EXPECT_THAT(error_of([&] { parse("no json"); }), HasSubstr("cannot be read"));
  std::string other = json;
  other.replace(other.find("LensDistortionModelBrownConrady"), 31, "LensDistortionModelRational6KT_");
  EXPECT_THAT(error_of([&] { parse(other); }), HasSubstr("lens model"));
}

// A wall at 2 m before both cameras, the colour camera 0.1 m to the right: what it sees at u, the depth camera sees
// f·b/z = 100·0.1/2 = 5 pixels further right.
TEST(Registration, ShiftsByTheParallax) {
  const Pinhole camera{100, 100, 19.5f, 14.5f, 40, 30};
  const ColorRegistration registration{camera, camera, {}, SE3(Matrix3d::Identity(), Vector3d(-0.1, 0, 0))};
  DepthImage depth(40, 30);
  std::fill(depth.pixels.begin(), depth.pixels.end(), 2000);
  depth.pixels[7 * 40 + 20] = 0;
  ColorImage image(40, 30, 3);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x)
      image.pixels[static_cast<std::size_t>(3 * (40 * y + x))] = static_cast<std::uint8_t>(5 * x);
  const ColorImage seen = registration.apply(depth, 1000, image);
  for (int x = 0; x < 40; ++x)
    EXPECT_EQ(seen.pixels[static_cast<std::size_t>(3 * (40 * 12 + x))], x < 5 ? 0 : 5 * (x - 5)) << x;
  EXPECT_EQ(seen.pixels[3 * (40 * 7 + 20)], 0);
  EXPECT_EQ(seen.pixels[3 * (40 * 7 + 21)], 80);
}

}  // namespace
}  // namespace plumbline
