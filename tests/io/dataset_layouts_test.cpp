// Folders as data sets and apps leave them, each made here as its makers describe it.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <cstring>

#include "io/layout_samples.h"
#include "io/recorded_camera.h"
#include "plumbline/error.h"
#include "plumbline/sequence.h"
#include "support/error_of.h"
#include "support/temp_folder.h"

#ifdef PLUMBLINE_OPENEXR
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#endif

namespace plumbline {
namespace {

using test::error_of;
using test::TempFolder;
using test::write_text;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr const char* kIdentity = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";

std::string pose_at(double x) { return fmt::format("1 0 0 {}\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", x); }

/// Poses at the frames' own stamps, the k-th `step`·k along x.
void expect_truth(const Sequence& sequence, double step, int first = 0) {
  const Trajectory truth = sequence.read_groundtruth();
  ASSERT_EQ(static_cast<int>(truth.size()), sequence.size());
  for (int i = 0; i < sequence.size(); ++i) {
    const StampedPose& pose = truth[static_cast<std::size_t>(i)];
    EXPECT_EQ(pose.time, sequence.time(i));
    EXPECT_NEAR(pose.world_from_camera.translation().x(), step * (first + i), 1e-9);
  }
}

// ---- What `simulate`, `record` and `convert` write

TEST(CameraJson, NothingIsGuessedOfAFolderThatHasIt) {
  const TempFolder folder;
  std::string list;
  for (int i = 0; i < 3; ++i) {
    write_slope(folder / fmt::format("depth/{}.png", i), 1001);
    list += fmt::format("1.{} depth/{}.png\n", i, i);
  }
  write_text(folder / "depth.txt", list);
  const Eigen::Matrix3d body_from_camera = (Eigen::Matrix3d() << 0, -1, 0, -1, 0, 0, 0, 0, -1).finished();
  write_camera_json(folder.path().string(), {50.25f, 51, 31, 23, kWidth, kHeight}, 1000, body_from_camera);
  const SequenceInfo info = open_folder(folder)->info();
  EXPECT_EQ(info.camera, (Pinhole{50.25f, 51, 31, 23, kWidth, kHeight}));
  EXPECT_EQ(info.depth_scale, 1000);
  EXPECT_FALSE(info.camera_is_guess || info.depth_scale_is_guess);
  ASSERT_TRUE(info.body_from_camera);
  EXPECT_TRUE(info.body_from_camera->isApprox(body_from_camera, 1e-9));
  EXPECT_THAT(info.warnings, IsEmpty());
  write_text(folder / "camera.json",
             "{\"fx\": 50, \"fy\": 50, \"cx\": 31, \"cy\": 23, \"body_from_camera\": [1, 1, 0, 0]}");
  EXPECT_THAT(error_of([&] { open_folder(folder); }), HasSubstr("no unit quaternion"));
}

// ---- Data sets with one file a frame

TEST(Eth3d, CalibrationAndTruthAreItsOwn) {
  const TempFolder folder;
  std::string depth = "# timestamp filename\n", color = depth, truth;
  for (int i = 0; i < 3; ++i) {
    const std::string stamp = fmt::format("7025.{}", 100 + 33 * i);
    write_slope(folder / ("depth/" + stamp + ".png"), 7501);
    write_color(folder / ("rgb/" + stamp + ".png"), 9);
    depth += stamp + " depth/" + stamp + ".png\n";
    color += stamp + " rgb/" + stamp + ".png\n";
    truth += fmt::format("{} {} 0 0 0 0 0 1\n", stamp, 0.1 * i);
  }
  write_text(folder / "depth.txt", depth);
  write_text(folder / "rgb.txt", color);
  write_text(folder / "groundtruth.txt", truth);
  write_text(folder / "calibration.txt", "50.5 50.25 31 23\n");
  const auto sequence = open_folder(folder);
  EXPECT_EQ(sequence->info().camera, (Pinhole{50.5f, 50.25f, 31, 23, kWidth, kHeight}));
  EXPECT_FALSE(sequence->info().camera_is_guess);
  EXPECT_EQ(sequence->info().depth_scale, 5000);
  EXPECT_EQ(sequence->info().color_frames, 3);
  expect_truth(*sequence, 0.1);
}

TEST(SevenScenesLayout, ThreeDMatch) {
  const TempFolder folder;
  write_text(folder / "camera-intrinsics.txt", " 5.0e+01\t 0.0e+00\t 3.1e+01\t\n 0 5.1e+01 2.3e+01\n 0 0 1\n");
  for (int i = 0; i < 3; ++i) {
    const std::string stem = fmt::format("seq-01/frame-00000{}.", i);
    write_slope(folder / (stem + "depth.png"), 1000);
    write_color(folder / (stem + "color.png"), 9);
    write_text(folder / (stem + "pose.txt"), pose_at(0.1 * i));
  }
  DepthImage saturated(kWidth, kHeight);
  std::fill(saturated.pixels.begin(), saturated.pixels.end(), std::uint16_t{65535});
  saturated.pixels[0] = 1500;
  write_depth_png(folder / "seq-01/frame-000001.depth.png", saturated);
  const auto sequence = open_folder(folder);
  EXPECT_EQ(sequence->info().camera, (Pinhole{50, 51, 31, 23, kWidth, kHeight}));
  EXPECT_EQ(sequence->info().color_frames, 3);
  EXPECT_EQ(sequence->read(1).depth.pixels[0], 1500);
  EXPECT_EQ(sequence->read(1).depth.pixels[1], 0) << "65535 is no reading";
  expect_truth(*sequence, 0.1);
}

/// BundleFusion and 12-Scenes: JPEG or PNG colour of another camera, both in info.txt.
void write_info(const std::string& path, double color_focal, int color_width, int color_height) {
  write_text(path, fmt::format(
                       "m_versionNumber = 4\nm_sensorName = StructureSensor\nm_colorWidth = {}\nm_colorHeight = {}\n"
                       "m_depthWidth = 64\nm_depthHeight = 48\nm_depthShift = 1000\n"
                       "m_calibrationColorIntrinsic = {} 0 {} 0 0 {} {} 0 0 0 1 0 0 0 0 1\n"
                       "m_calibrationColorExtrinsic = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n"
                       "m_calibrationDepthIntrinsic = 50 0 31 0 0 51 23 0 0 0 1 0 0 0 0 1\n"
                       "m_calibrationDepthExtrinsic = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\nm_frames.size = 3\n",
                       color_width, color_height, color_focal, color_width / 2 - 1, color_focal, color_height / 2 - 1));
}

TEST(SevenScenesLayout, TwelveScenesColourIsOfAnotherCamera) {
  const TempFolder folder;
  for (int i = 0; i < 3; ++i) {
    const std::string stem = fmt::format("kitchen/data/frame-00000{}.", i);
    write_slope(folder / (stem + "depth.png"), 1000);
    write_color(folder / (stem + "color.jpg"), static_cast<std::uint8_t>(40 + i), 128, 96);  // told by its bytes
    write_text(folder / (stem + "pose.txt"), pose_at(0.2 * i));
  }
  write_info(folder / "kitchen/info.txt", 100, 128, 96);
  const auto sequence = open_sequence(folder / "kitchen/data");
  EXPECT_EQ(sequence->info().camera, (Pinhole{50, 51, 31, 23, kWidth, kHeight}));
  EXPECT_THAT(sequence->info().camera_source, HasSubstr("info.txt"));
  EXPECT_EQ(sequence->info().color_frames, 3);
  EXPECT_THAT(sequence->info().notes, Contains(HasSubstr("colour of 128x96 is sampled at the depth's 64x48 pixels")));
  const Frame frame = sequence->read(1);
  EXPECT_EQ(frame.color.width, kWidth);
  EXPECT_EQ(frame.color.at(30, 20, 1), 41);
  expect_truth(*sequence, 0.2);
}

TEST(SevenScenesLayout, BundleFusion) {
  const TempFolder folder;
  for (int i = 0; i < 3; ++i) {
    const std::string stem = fmt::format("apt0/frame-00000{}.", i);
    write_slope(folder / (stem + "depth.png"), 1000);
    write_color(folder / (stem + "color.jpg"), 40);
    write_text(folder / (stem + "pose.txt"), i == 1 ? "-inf -inf -inf -inf\n-inf -inf -inf -inf\n-inf -inf -inf -inf\n"
                                                      "-inf -inf -inf -inf\n"
                                                    : kIdentity);
  }
  write_info(folder / "apt0/info.txt", 50, 64, 48);
  const auto sequence = open_sequence(folder / "apt0");
  EXPECT_EQ(sequence->info().camera.fx, 50);
  EXPECT_EQ(sequence->info().depth_scale, 1000);
  EXPECT_EQ(sequence->info().color_frames, 3);
  EXPECT_EQ(sequence->read_groundtruth().size(), 2U) << "a frame that was lost has no pose";
}

// ---- Folders with depth/ and color/

TEST(ScanNetExport, CamerasOfBothAndPosesByNumber) {
  const TempFolder folder;
  for (const int i : {0, 1, 2, 10}) {
    write_slope(folder / fmt::format("depth/{}.png", i), 1000);
    write_color(folder / fmt::format("color/{}.jpg", i), static_cast<std::uint8_t>(40 + i), 128, 96);
    write_text(folder / fmt::format("pose/{}.txt", i), pose_at(0.1 * i));
  }
  write_text(folder / "intrinsic/intrinsic_depth.txt", "50 0 31 0\n0 51 23 0\n0 0 1 0\n0 0 0 1\n");
  write_text(folder / "intrinsic/intrinsic_color.txt", "100 0 63 0\n0 102 47 0\n0 0 1 0\n0 0 0 1\n");
  const auto sequence = open_folder(folder);
  EXPECT_EQ(sequence->info().camera, (Pinhole{50, 51, 31, 23, kWidth, kHeight}));
  EXPECT_EQ(sequence->info().depth_scale, 1000);
  EXPECT_EQ(sequence->info().color_frames, 4);
  EXPECT_EQ(sequence->read(3).color.at(30, 20, 0), 50) << "2 comes before 10";
  const Trajectory truth = sequence->read_groundtruth();
  ASSERT_EQ(truth.size(), 4U);
  EXPECT_EQ(truth[3].time, sequence->time(3));
  EXPECT_NEAR(truth[3].world_from_camera.translation().x(), 1, 1e-12) << "the pose of number 10";
}

TEST(Redwood, TheLogIsTheTruth) {
  const TempFolder folder;
  std::string log;
  for (int i = 0; i < 3; ++i) {
    const std::string name = fmt::format("0000{}-00000003336{}.", i + 1, i);
    write_slope(folder / ("depth/" + name + "png"), 1000);
    write_color(folder / ("image/" + name + "jpg"), static_cast<std::uint8_t>(40 + i));
    log += fmt::format("{} {} {}\n", i, i, i + 1) + pose_at(0.1 * i);
  }
  write_text(folder / "lounge_trajectory.log", log);
  const auto sequence = open_folder(folder, small_camera());
  EXPECT_EQ(sequence->info().color_frames, 3);
  EXPECT_EQ(sequence->read(2).color.pixels[0], 42);
  EXPECT_THAT(sequence->info().groundtruth, HasSubstr("lounge_trajectory.log"));
  expect_truth(*sequence, 0.1);
  write_text(folder / "lounge_trajectory.log", "started\n1 2 3\nended\n4\n5\n6\n");
  EXPECT_THAT(open_folder(folder, small_camera())->info().groundtruth, IsEmpty()) << "a log of a program";
}

TEST(Sun3d, RotatedBitsStampsAndExtrinsics) {
  const TempFolder folder;
  std::string poses;
  for (int i = 0; i < 3; ++i) {
    DepthImage depth(kWidth, kHeight);
    for (std::size_t k = 0; k < depth.pixels.size(); ++k) {
      const std::uint32_t millimetres = k == 0 ? 8191 + 1 : 1000 + static_cast<std::uint32_t>(k) % 999;  // of 16 bits
      depth.pixels[k] = static_cast<std::uint16_t>(millimetres << 3 | millimetres >> 13);
    }
    depth.pixels[0] = static_cast<std::uint16_t>(7000 << 3);
    fs::create_directories(folder / "depth");
    write_depth_png(folder / fmt::format("depth/000000{}-00000003336{}.png", i + 1, 6 + i), depth);
    write_color(folder / fmt::format("image/000000{}-00000003337{}.jpg", i + 1, i), 40);
    poses += fmt::format("1 0 0 {}\n0 1 0 0\n0 0 1 0\n", 0.3 * i);
  }
  write_text(folder / "intrinsics.txt", "50 0 31\n0 51 23\n0 0 1\n");
  write_text(folder / "extrinsics/20130101000000.txt", "1 0 0 9\n0 1 0 0\n0 0 1 0\n");
  write_text(folder / "extrinsics/20130512130736.txt", poses);
  const auto sequence = open_folder(folder);
  EXPECT_EQ(sequence->info().depth_scale, 1000);
  EXPECT_FALSE(sequence->info().depth_scale_is_guess);
  EXPECT_EQ(sequence->read(0).depth.pixels[0], 7000);
  EXPECT_EQ(sequence->read(0).depth.pixels[5], 1005);
  EXPECT_EQ(sequence->time(1), 33'367'000);
  EXPECT_EQ(sequence->info().color_frames, 3);
  expect_truth(*sequence, 0.3);
}

TEST(Bonn, TheFoldersNameIsAGuessOfTheCameraAlone) {
  const TempFolder folder;
  std::string list;
  for (int i = 0; i < 3; ++i) {
    write_slope(folder / fmt::format("rgbd_bonn_balloon/depth/{}.png", i), 7501, 640, 480);
    list += fmt::format("154836{}.1 depth/{}.png\n", i, i);
  }
  write_text(folder / "rgbd_bonn_balloon/depth.txt", list);
  const SequenceInfo info = open_sequence(folder / "rgbd_bonn_balloon")->info();
  EXPECT_NEAR(info.camera.fx, 542.822841f, 1e-4);
  EXPECT_TRUE(info.camera_is_guess);
  EXPECT_THAT(info.notes, Contains(AllOf(HasSubstr("a guess"), HasSubstr("'bonn' in the folder's name"))));
  EXPECT_TRUE(info.depth_scale_is_guess);
}

TEST(NyuDepth, ElevenBitsAreMetresThroughTheToolboxsFormula) {
  for (const bool swapped : {true, false}) {
    const TempFolder folder;
    for (int i = 0; i < 3; ++i) {
      std::string depth = "P5\n640 480\n65535\n", color = "P6\n640 480\n255\n";
      for (int k = 0; k < 640 * 480; ++k) {
        const int raw = k % 640 == 0 ? 2047 : 700 + k % 200;
        const char high = static_cast<char>(raw >> 8), low = static_cast<char>(raw & 255);
        depth += swapped ? std::string{low, high} : std::string{high, low};
        color += std::string{static_cast<char>(k % 640 / 3), 60, 70};
      }
      write_text(folder / fmt::format("d-1294886362.{}65769-2143162612.pgm", i), depth);
      write_text(folder / fmt::format("r-1294886362.{}70000-2143162612.ppm", i), color);
      write_text(folder / fmt::format("a-1294886362.{}65769-2143162612.dump", i), "x");
    }
    SequenceOptions options;
    options.undistort = false;
    const auto sequence = open_folder(folder, options);
    EXPECT_EQ(sequence->info().format, "NYU Depth, raw");
    ASSERT_EQ(sequence->size(), 3);
    EXPECT_EQ(sequence->time(1), 1294886362165769000);
    const Frame frame = sequence->read(0);
    EXPECT_EQ(frame.depth.at(0, 7), 0);
    const int raw = 700 + (240 * 640 + 320) % 200;
    EXPECT_NEAR(frame.depth.at(320, 240) / frame.depth_scale, 351.3 / (1092.5 - raw), 1e-4);
    // The colour camera stands 2.5 cm to the right of depth's.
    const double z = 351.3 / (1092.5 - raw), u = 518.858 * ((320 - 313.045) / 582.624 - 0.0043 - 0.02503 / z) + 325.58;
    EXPECT_NEAR(frame.color.at(320, 240, 0), u / 3, 1.5);
    EXPECT_THAT(sequence->info().notes, Contains(HasSubstr("accelerometer (a-*.dump) is not used")));
  }
}

TEST(OpenLoris, AlignedDepthMillimetresAndTheSensorsApart) {
  const TempFolder folder;
  std::string depth, color, gyroscope = "#Time gyr_x gyr_y gyr_z\n", accelerometer = "#Time acc_x acc_y acc_z\n";
  for (int i = 0; i < 3; ++i) {
    const std::string stamp = fmt::format("1560000032.{}", 100 + 33 * i);
    write_slope(folder / ("aligned_depth/" + stamp + ".png"), 1001);
    write_slope(folder / ("depth/" + stamp + ".png"), 1001);
    write_color(folder / ("color/" + stamp + ".png"), 40);
    depth += stamp + " aligned_depth/" + stamp + ".png\n";
    color += stamp + " color/" + stamp + ".png\n";
  }
  for (int i = 0; i < 40; ++i) {
    gyroscope += fmt::format("1560000032.{:03d} 0.5 0 0\n", 100 + 5 * i);
    if (i % 2 == 0) accelerometer += fmt::format("1560000032.{:03d} 0 {} 0\n", 100 + 5 * i, -9.7 - 0.001 * i);
  }
  write_text(folder / "aligned_depth.txt", depth);
  write_text(folder / "depth.txt", depth);
  write_text(folder / "color.txt", color);
  write_text(folder / "d400_gyroscope.txt", gyroscope);
  write_text(folder / "d400_accelerometer.txt", accelerometer);
  const auto sensors = [&](const char* order) {
    return fmt::format(
        "%YAML:1.0\nd400_color_optical_frame:\n   width: 64\n   height: 48\n   fps: 30\n"
        "   distortion_model: none\n   distortion_coefficients: [0.,0.,0.,0.,0.]\n"
        "   intrinsics: !!opencv-matrix\n      rows: 1\n      cols: 4\n      dt: d\n      data: [ {} ]\n"
        "d400_imu:\n   imu_intrinsic: !!opencv-matrix\n      rows: 1\n      cols: 2\n      dt: d\n"
        "      data: [1., 2.]\n",
        order);
  };
  for (const char* order : {"5.0e+01, 3.1e+01,\n              5.1e+01, 2.3e+01", "50, 51, 31, 23"}) {
    write_text(folder / "sensors.yaml", sensors(order));
    const auto sequence = open_folder(folder);
    EXPECT_EQ(sequence->info().format, "OpenLORIS-Scene");
    EXPECT_EQ(sequence->info().camera, (Pinhole{50, 51, 31, 23, kWidth, kHeight})) << order;
    EXPECT_EQ(sequence->info().depth_scale, 1000);
    EXPECT_EQ(sequence->info().color_frames, 3);
    const ImuRecording imu = sequence->read_imu();
    ASSERT_GE(imu.samples.size(), 39U);
    EXPECT_NEAR(imu.samples[5].specific_force.y(), -9.705, 1e-9) << "between the readings before and after";
    ASSERT_TRUE(sequence->info().body_from_camera);
  }
  write_text(folder / "groundtruth.txt", "1560000032.1 1 2 3 0 0 0 1\n1560000032.2 1 2 4 0 0 0 1\n");
  EXPECT_THAT(open_folder(folder)->info().notes, Contains(HasSubstr("may be those of the robot's base")));
  write_text(
      folder / "trans_matrix.yaml",
      "trans_matrix:\n -\n   parent_frame: base_link\n   child_frame: laser\n   matrix: !!opencv-matrix\n      rows: "
      "4\n"
      "      cols: 4\n      dt: d\n      data: [ 1, 0, 0, 0.5, 0, 1, 0, 0,\n         0, 0, 1, 0, 0, 0, 0, 1 ]\n -\n"
      "   parent_frame: \"d400_color\"\n   child_frame: \"laser\"\n   matrix: !!opencv-matrix\n"
      "      data: [ 1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0.25, 0, 0, 0, 1 ]\n");
  const Trajectory truth = open_folder(folder)->read_groundtruth();
  ASSERT_EQ(truth.size(), 2U);
  // base_from_color = base_from_laser * inverse(color_from_laser): x + 0.5, then the inverse of a quarter turn.
  EXPECT_TRUE(truth[1].world_from_camera.translation().isApprox(Eigen::Vector3d(1.5, 2.25, 4), 1e-9))
      << truth[1].world_from_camera.translation().transpose();
  write_text(folder / "sensors.yaml", "%YAML:1.0\nd400_imu:\n   rate: 5\n");
  EXPECT_THAT(error_of([&] { open_folder(folder); }), HasSubstr("no intrinsics of d400_color"));
}

// ---- Apps for phones

TEST(ScannerApp, PosesCamerasAndTimesOfEachFrame) {
  const TempFolder folder;
  for (int i = 0; i < 3; ++i) {
    write_slope(folder / fmt::format("depth_0000{}.png", i), 1000);
    ColorImage confidence(kWidth, kHeight, 1);
    std::fill(confidence.pixels.begin(), confidence.pixels.end(), std::uint8_t{2});
    confidence.at(3, 0) = 0;
    write_color_png(folder / fmt::format("conf_0000{}.png", i), confidence);
    if (i != 1) write_color(folder / fmt::format("frame_0000{}.jpg", i), 70, 128, 96);
    write_text(folder / fmt::format("frame_0000{}.json", i),
               fmt::format(R"({{"cameraPoseARFrame": [1,0,0,{}, 0,1,0,0, 0,0,1,0, 0,0,0,1], "frame_index": {},
                             "intrinsics": [{}, 0, 63, 0, 101, 47, 0, 0, 1], "time": {}}})",
                           0.1 * i, i, 100 + i, 5000.5 + 0.1 * i));
  }
  const auto sequence = open_folder(folder);
  EXPECT_EQ(sequence->info().format, "3D Scanner App");
  ASSERT_EQ(sequence->size(), 3);
  EXPECT_EQ(sequence->time(1), 5'000'600'000'000);
  EXPECT_NEAR(sequence->info().camera.fx, 101.0 / 2, 1e-4) << "that in the middle, scaled to depth";
  EXPECT_THAT(sequence->info().notes, Contains(HasSubstr("differ by up to 0.99 %")));
  EXPECT_EQ(sequence->info().color_frames, 2);
  EXPECT_EQ(sequence->read(0).color.at(30, 20, 0), 70);
  EXPECT_EQ(sequence->read(0).depth.at(3, 0), 0) << "of the lowest confidence";
  EXPECT_GT(sequence->read(0).depth.at(4, 0), 0);
  expect_truth(*sequence, 0.1);
  const Eigen::Matrix3d axes = sequence->read_groundtruth()[0].world_from_camera.rotation();
  EXPECT_TRUE(axes.isApprox(Eigen::Vector3d(1, -1, -1).asDiagonal().toDenseMatrix())) << "y down, z forward";
}

TEST(ScannerApp, EachImageIsBroughtToOneCamera) {
  const TempFolder folder;
  for (int i = 0; i < 3; ++i) {  // planes x = 0.2 z, seen with the focal lengths 90, 100 and 110 of 128 pixels
    const double f = 45 + 5 * i;
    DepthImage depth(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) depth.at(x, y) = (x - 31.5) / f > 0.2 ? 2001 : 1001;
    write_depth_png(folder / fmt::format("depth_0000{}.png", i), depth);
    ColorImage color(2 * kWidth, 2 * kHeight, 3);
    for (int y = 0; y < color.height; ++y)
      for (int x = 0; x < color.width; ++x)
        for (int c = 0; c < 3; ++c) color.at(x, y, c) = (x - 63.5) / (2 * f) > 0.2 ? 200 : 20;
    write_color_png(folder / fmt::format("frame_0000{}.jpg", i), color);
    write_text(folder / fmt::format("frame_0000{}.json", i),
               fmt::format(R"({{"intrinsics": [{0}, 0, 63.5, 0, {0}, 47.5, 0, 0, 1], "time": {1}}})", 2 * f, i));
  }
  const auto sequence = open_folder(folder);
  EXPECT_FLOAT_EQ(sequence->info().camera.fx, 50);
  for (int i = 0; i < 3; ++i) {
    const Frame frame = sequence->read(i);
    EXPECT_EQ(frame.depth.at(41, 20), 1001) << i;
    EXPECT_EQ(frame.depth.at(43, 20), 2001) << i;
    EXPECT_EQ(frame.color.at(40, 20, 0), 20) << i;
    EXPECT_EQ(frame.color.at(44, 20, 0), 200) << i;
  }
  SequenceOptions given;
  given.intrinsics = Pinhole{50, 50, 31.5f, 23.5f, 0, 0};
  EXPECT_EQ(open_folder(folder, given)->read(2).depth.at(42, 20), 1001) << "as it is, where one camera is given";
}

TEST(Polycam, FilesInFoldersByTheirStamps) {
  const TempFolder folder;
  for (int i = 0; i < 3; ++i) {
    const std::string stem = fmt::format("170000000{:04}", 100 * i);
    write_slope(folder / ("keyframes/depth/" + stem + ".png"), 1001);
    write_color(folder / ("keyframes/images/" + stem + ".jpg"), 70, 128, 96);
    fs::create_directories(folder.path() / "keyframes/cameras");
    write_text(folder / ("keyframes/cameras/" + stem + ".json"),
               fmt::format(R"({{"fx": 100, "fy": 100, "cx": 63.5, "cy": 47.5, "width": 128, "height": 96,
                               "timestamp": {}, "t_00": 1, "t_01": 0, "t_02": 0, "t_03": {}, "t_10": 0, "t_11": 1,
                               "t_12": 0, "t_13": 0, "t_20": 0, "t_21": 0, "t_22": 1, "t_23": 0}})",
                           1'700'000'000'000'000 + 100'000 * i, 0.1 * i));
  }
  const auto sequence = open_folder(folder);
  EXPECT_EQ(sequence->info().format, "Polycam");
  EXPECT_EQ(sequence->info().camera, (Pinhole{50, 50, 31.5f, 23.5f, kWidth, kHeight}));
  EXPECT_EQ(sequence->time(2) - sequence->time(1), 100'000'000);
  EXPECT_EQ(sequence->read(1).color.at(30, 20, 0), 70);
  expect_truth(*sequence, 0.1);
}

#ifdef PLUMBLINE_OPENEXR
void write_exr(const std::string& path, const char* channel, float (*value)(int x, int y), Imf::PixelType type) {
  fs::create_directories(fs::path(path).parent_path());
  Imf::Header header(kWidth, kHeight);
  header.channels().insert(channel, Imf::Channel(type));
  std::vector<float> floats;
  std::vector<half> halves;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) floats.push_back(value(x, y)), halves.emplace_back(value(x, y));
  const std::size_t size = type == Imf::HALF ? sizeof(half) : sizeof(float);
  char* data = type == Imf::HALF ? reinterpret_cast<char*>(halves.data()) : reinterpret_cast<char*>(floats.data());
  Imf::FrameBuffer buffer;
  buffer.insert(channel, Imf::Slice(type, data, size, size * kWidth));
  Imf::OutputFile file(path.c_str(), header);
  file.setFrameBuffer(buffer);
  file.writePixels(kHeight);
}

float metres(int x, int y) { return x == 0 ? NAN : 1 + 0.01f * static_cast<float>(x) + (y > 20 ? 0.5f : 0.f); }

TEST(Record3d, DepthAsExrAndTheMetadatasPoses) {
  const TempFolder folder;
  for (int i = 0; i < 3; ++i) {
    write_exr(folder / fmt::format("EXR_RGBD/depth/{}.exr", i), i == 0 ? "R" : "Z", metres,
              i == 1 ? Imf::HALF : Imf::FLOAT);
    write_color(folder / fmt::format("EXR_RGBD/rgb/{}.jpg", i), 70, 128, 96);
  }
  const auto metadata = [&](const std::string& times) {
    write_text(folder / "metadata.json",
               R"({"w": 128, "h": 96, "K": [100, 0, 0, 0, 102, 0, 63, 47, 1], )" + times +
                   R"(, "poses": [[0,0,0,1, 0,0,0], [0,0,0,1, 0.1,0,0], [0,0,0,1, 0.2,0,0]]})");
  };
  metadata("\"fps\": 15");
  auto sequence = open_folder(folder);
  EXPECT_EQ(sequence->info().format, "Record3D");
  EXPECT_NEAR(sequence->info().camera.fx, 50, 1e-4);
  EXPECT_NEAR(sequence->info().camera.cx, 63.5 / 2 - 0.5, 1e-4);
  EXPECT_EQ(sequence->time(1), from_seconds(1.0 / 15));
  for (int i = 0; i < 3; ++i) {
    const Frame frame = sequence->read(i);
    EXPECT_EQ(frame.depth.at(0, 5), 0);
    EXPECT_NEAR(frame.depth.at(40, 30) / frame.depth_scale, 1.9, 1e-3);
    EXPECT_NEAR(frame.depth.at(40, 3) / frame.depth_scale, 1.4, 1e-3);
    EXPECT_EQ(frame.color.at(30, 20, 0), 70);
  }
  expect_truth(*sequence, 0.1);
  EXPECT_NEAR(sequence->read_groundtruth()[0].world_from_camera.rotation()(2, 2), -1, 1e-12) << "z forward";
  metadata("\"frameTimestamps\": [0.5, 0.6, 0.75]");
  EXPECT_EQ(open_folder(folder)->time(2), 750'000'000);
  write_text(folder / "metadata.json", "{\"K\": [1, 2]}");
  EXPECT_THAT(error_of([&] { open_folder(folder); }), HasSubstr("metadata.json"));
}

TEST(Exr, DamagedFilesCostTheirFrame) {
  const TempFolder folder;
  for (int i = 0; i < 3; ++i) write_exr(folder / fmt::format("depth/{}.exr", i), "Y", metres, Imf::FLOAT);
  const std::string bytes = test::read_text(folder / "depth/1.exr");
  write_text(folder / "depth/1.exr", bytes.substr(0, bytes.size() / 2));
  const auto sequence = open_folder(folder, small_camera());
  EXPECT_NEAR(sequence->read(2).depth.at(40, 30) / sequence->info().depth_scale, 1.9, 1e-3);
  EXPECT_THAT(error_of([&] { sequence->read(1); }), AllOf(HasSubstr("1.exr"), HasSubstr("damaged EXR")));
}
#endif

TEST(Plausibility, RealNumbersOfMillimetres) {
  const TempFolder folder;
  std::string head = "{'descr': '<f4', 'fortran_order': False, 'shape': (48, 64), }";
  head.resize(118, ' ');
  for (int i = 0; i < 3; ++i) {
    std::string bytes = std::string("\x93NUMPY\x01\x00\x76\x00", 10) + head;
    for (int k = 0; k < kWidth * kHeight; ++k) {
      const float value = 1500 + static_cast<float>(k % 300);
      bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
    write_text(folder / fmt::format("depth/{}.npy", i), bytes);
  }
  EXPECT_THAT(open_folder(folder, small_camera())->info().warnings,
              warns_of("in the median: they seem to be millimetres", "--depth-scale 1000"));
  SequenceOptions options = small_camera();
  options.depth_scale = 1000;
  const auto sequence = open_folder(folder, options);
  EXPECT_THAT(sequence->info().warnings, Not(warns_of("millimetres", "")));
  EXPECT_NEAR(sequence->read(0).depth.pixels[0] / sequence->info().depth_scale, 1.5, 1e-3);
}

}  // namespace
}  // namespace plumbline
