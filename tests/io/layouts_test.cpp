// Folders as scanning apps, cameras' recorders and data sets leave them: what each says of itself is believed.
#include <gmock/gmock.h>
#include <tiffio.h>

#include <filesystem>

#include "io/checks/plausibility.h"
#include "io/images/png.h"
#include "io/layout_samples.h"
#include "io/recorded_camera.h"
#include "plumbline/error.h"
#include "plumbline/prefetch.h"
#include "plumbline/sequence.h"
#include "support/data.h"
#include "support/error_of.h"
#include "support/temp_folder.h"

namespace plumbline {
namespace {

using test::error_of;
using test::TempFolder;
using test::write_text;
using testing::AllOf;
using testing::Contains;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
// ---- StrayScanner

void write_stray_scanner(const TempFolder& folder) {
  std::string odometry = "timestamp, frame, x, y, z, qx, qy, qz, qw\n";
  for (int i = 0; i < 3; ++i) {
    write_slope(folder / ("depth/00000" + std::to_string(i) + ".png"), 1000);
    ColorImage confidence(kWidth, kHeight, 1);
    std::fill(confidence.pixels.begin(), confidence.pixels.end(), std::uint8_t{2});
    confidence.at(0, 0) = 0;
    confidence.at(1, 0) = 1;
    fs::create_directories(folder.path() / "confidence");
    write_color_png(folder / ("confidence/00000" + std::to_string(i) + ".png"), confidence);
    odometry += "100." + std::to_string(i) + ", 00000" + std::to_string(i) + ", 0." + std::to_string(i) +
                ", 0, 0, 0, 0, 0, 1\n";
  }
  write_text(folder / "odometry.csv", odometry);
  write_text(folder / "camera_matrix.csv", "1500, 0.0, 958.5\n0.0, 1500, 718.5\n0.0, 0.0, 1.0\n");
  write_text(folder / "imu.csv", "timestamp, a_x, a_y, a_z, alpha_x, alpha_y, alpha_z\n100.0,0,0,-1,0,0,0\n");
}

TEST(StrayScanner, IntrinsicsOfTheVideoAreScaledToDepth) {
  const TempFolder folder;
  write_stray_scanner(folder);
  const auto sequence = open_folder(folder);
  const SequenceInfo& info = sequence->info();
  EXPECT_EQ(info.format, "StrayScanner");
  EXPECT_NEAR(info.camera.fx, 1500.0 * 64 / 1920, 1e-4);
  EXPECT_NEAR(info.camera.cx, (958.5 + 0.5) * 64 / 1920 - 0.5, 1e-4) << "pixel centres keep their place";
  EXPECT_NEAR(info.camera.cy, (718.5 + 0.5) * 48 / 1440 - 0.5, 1e-4);
  EXPECT_EQ(info.depth_scale, 1000);
  EXPECT_FALSE(info.camera_is_guess);
  EXPECT_EQ(sequence->time(1), 100'100'000'000);
  const Trajectory truth = sequence->read_groundtruth();
  ASSERT_EQ(truth.size(), 3u);
  EXPECT_EQ(truth[2].time, sequence->time(2));
  EXPECT_NEAR(truth[2].world_from_camera.translation().x(), 0.2, 1e-12);
  ASSERT_TRUE(info.body_from_camera);
  EXPECT_NEAR(info.body_from_camera->determinant(), 1, 1e-12);
}

TEST(StrayScanner, ReadingsOfTheLowestConfidenceAreLeftOut) {
  const TempFolder folder;
  write_stray_scanner(folder);
  const auto row = [&](int min_confidence) {
    SequenceOptions options;
    options.min_confidence = min_confidence;
    const Frame frame = open_folder(folder, options)->read(0);
    return std::vector<bool>{frame.depth.at(0, 0) > 0, frame.depth.at(1, 0) > 0, frame.depth.at(2, 0) > 0};
  };
  EXPECT_EQ(row(1), (std::vector<bool>{false, true, true}));
  EXPECT_EQ(row(2), (std::vector<bool>{false, false, true}));
  EXPECT_EQ(row(0), (std::vector<bool>{true, true, true}));
  EXPECT_THAT(open_folder(folder)->info().notes, Contains(HasSubstr("confidence below 1 are left out")));
}

TEST(StrayScanner, ARealWalk) {
  PLUMBLINE_DATA_OR_SKIP(path, "phone/lidar_walk");
  const auto sequence = open_sequence(path.string());
  const SequenceInfo& info = sequence->info();
  EXPECT_EQ(info.frames, 942);
  EXPECT_NEAR(info.camera.fx, 180.27, 0.01);
  EXPECT_NEAR(info.camera.cx, 127.84, 0.01);
  EXPECT_NEAR(info.camera.cy, 95.95, 0.01);
  EXPECT_THAT(info.warnings, IsEmpty());
  EXPECT_EQ(sequence->read_groundtruth().size(), 942u);
}

// ---- Depth and colour in folders and side by side

TEST(Open3dRecorder, ItsIntrinsicsAndColorAreRead) {
  const TempFolder folder;
  for (const int i : {0, 1, 2}) {
    write_slope(folder / ("depth/00000" + std::to_string(i) + ".png"), 1000);
    write_color(folder / ("color/00000" + std::to_string(i) + ".png"), static_cast<std::uint8_t>(10 + i));
  }
  write_text(folder / "camera_intrinsic.json",
             R"({"width": 64, "height": 48, "intrinsic_matrix": [50, 0, 0, 0, 51, 0, 31, 23, 1]})");
  const auto sequence = open_folder(folder);
  EXPECT_EQ(sequence->info().camera, (Pinhole{50, 51, 31, 23, 64, 48}));
  EXPECT_THAT(sequence->info().camera_source, HasSubstr("camera_intrinsic.json"));
  EXPECT_EQ(sequence->info().color_frames, 3);
  EXPECT_EQ(sequence->read(2).color.pixels[0], 12);
}

TEST(DepthFolder, DepthAndColorSideBySide) {
  const TempFolder folder;
  for (const int i : {0, 1, 2}) {
    write_slope(folder / ("frame0000" + std::to_string(i) + "_depth.png"), 1000);
    write_color(folder / ("frame0000" + std::to_string(i) + "_rgb.png"), static_cast<std::uint8_t>(10 + i));
  }
  const auto sequence = open_folder(folder, small_camera());
  ASSERT_EQ(sequence->size(), 3);
  EXPECT_EQ(sequence->info().color_frames, 3);
  EXPECT_EQ(sequence->read(1).color.pixels[0], 11);
}

TEST(DepthFolder, ColorOfAnotherSizeIsLeftOutWithItsReason) {
  const TempFolder folder;
  write_slope(folder / "depth/0.png", 1000);
  write_color(folder / "rgb/0.png", 9, 128, 96);
  const auto sequence = open_folder(folder, small_camera());
  EXPECT_EQ(sequence->info().color_frames, 0);
  EXPECT_THAT(sequence->info().notes, Contains(HasSubstr("colour is not used, because")));
}

TEST(Replica, ScaleCameraAndPosesAreTheRecordingsOwn) {
  const TempFolder folder;
  write_slope(folder / "room0/results/depth000000.png", 6000);
  write_slope(folder / "room0/results/depth000001.png", 6000);
  write_color(folder / "room0/results/frame000001.png", 7);
  write_text(folder / "room0/traj.txt", "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n1 0 0 0.5 0 1 0 0 0 0 1 0 0 0 0 1\n");
  write_text(folder / "cam_params.json",
             R"({"camera": {"w": 64, "h": 48, "fx": 50, "fy": 50, "cx": 31.5, "cy": 23.5, "scale": 6553.5}})");
  const auto sequence = open_sequence(folder / "room0");
  EXPECT_EQ(sequence->info().format, "Replica");
  EXPECT_EQ(sequence->info().depth_scale, 6553.5);
  EXPECT_EQ(sequence->info().camera.fx, 50);
  EXPECT_FALSE(sequence->read(1).color.empty());
  const Trajectory truth = sequence->read_groundtruth();
  ASSERT_EQ(truth.size(), 2u);
  EXPECT_EQ(truth[1].time, sequence->time(1));
  EXPECT_EQ(truth[1].world_from_camera.translation().x(), 0.5);
}

TEST(DepthFolder, RealNumbersOfMetresInTiff) {
  const TempFolder folder;
  const std::string path = folder / "1721362630.651355_depth.tiff";
  TIFF* tiff = TIFFOpen(path.c_str(), "w");
  ASSERT_NE(tiff, nullptr);
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, kWidth);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, kHeight);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 32);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_IEEEFP);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, kHeight);
  std::vector<float> row(kWidth, 1.5f);
  row[3] = NAN;
  for (std::uint32_t y = 0; y < kHeight; ++y) ASSERT_EQ(TIFFWriteScanline(tiff, row.data(), y), 1);
  TIFFClose(tiff);
  const auto sequence = open_folder(folder, small_camera());
  const Frame frame = sequence->read(0);
  EXPECT_NEAR(frame.depth.at(0, 0) / frame.depth_scale, 1.5, 1e-3);
  EXPECT_EQ(frame.depth.at(3, 0), 0);
  EXPECT_EQ(frame.time, 1721362630651355000);
}

TEST(DepthFolder, PgmAndNpy) {
  const TempFolder pgm, npy;
  std::string bytes = "P5\n# by a recorder\n4 3\n65535\n";
  for (int i = 0; i < 12; ++i) bytes += std::string("\x04\x03", 2);  // 1027
  write_text(pgm / "0.pgm", bytes);
  SequenceOptions options;
  options.intrinsics = Pinhole{4, 4, 1.5f, 1, 0, 0};
  EXPECT_EQ(open_folder(pgm, options)->read(0).depth.at(3, 2), 1027);
  std::string head = "{'descr': '<f4', 'fortran_order': False, 'shape': (3, 4), }";
  head.resize(118, ' ');
  bytes = std::string("\x93NUMPY\x01\x00\x76\x00", 10) + head;
  for (int i = 0; i < 12; ++i) {
    const float value = 2;
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  write_text(npy / "0.npy", bytes);
  const Frame frame = open_folder(npy, options)->read(0);
  EXPECT_NEAR(frame.depth.at(3, 2) / frame.depth_scale, 2, 1e-3);
}

// ---- What a folder's name must not do

TEST(DepthFolder, ANameChangesNeitherScaleNorSign) {
  const TempFolder folder;
  for (const char* name : {"living_room_scan", "icl-mine", "traj0_mine"}) {
    for (const int i : {0, 1, 2})
      write_slope(folder.path() / name / "depth" / (std::to_string(i) + ".png"), 1000, 640, 480);
    SequenceOptions options;
    options.camera = "kinect";
    const auto sequence = open_sequence((folder.path() / name).string(), options);
    EXPECT_EQ(sequence->info().depth_scale, 1000) << name;
    EXPECT_GT(sequence->info().camera.fy, 0) << name;
    EXPECT_LT(sequence->time(1), kNanosecondsPerSecond) << name;
  }
}

// ---- Does it add up?

void write_tum(const TempFolder& folder, int near, const std::string& stamp_of = "") {
  std::string list;
  for (int i = 0; i < 6; ++i) {
    const std::string name = "depth/" + std::to_string(i) + ".png";
    write_slope(folder / name, near, 640, 480);
    list += (stamp_of.empty() ? "1.0" + std::to_string(i) : stamp_of) + " " + name + "\n";
  }
  write_text(folder / "depth.txt", list);
}

TEST(Plausibility, MillimetresInATumFolderAreAskedAbout) {
  const TempFolder folder;
  write_tum(folder, 1101);
  const auto sequence = open_folder(folder);
  EXPECT_TRUE(sequence->info().depth_scale_is_guess);
  EXPECT_THAT(sequence->info().warnings, warns_of("scale is probably wrong", "--depth-scale 1000"));
  SequenceOptions strict;
  strict.strict = true;
  EXPECT_THAT(error_of([&] { open_folder(folder, strict); }), HasSubstr("--depth-scale 1000"));
  SequenceOptions given;
  given.depth_scale = 1000;
  EXPECT_THAT(open_folder(folder, given)->info().warnings, Not(warns_of("scale", "")));
}

TEST(Plausibility, TwoScalesThatFitAreAskedAbout) {
  const TempFolder folder;
  write_tum(folder, 1751);
  EXPECT_THAT(open_folder(folder)->info().warnings, warns_of("5000 and 1000 readings a metre are both plausible", ""));
}

TEST(Plausibility, ReadingsThatAreTooFarNameTheLikelyScales) {
  const TempFolder folder;
  for (const int i : {0, 1, 2}) write_slope(folder / ("depth00000" + std::to_string(i) + ".png"), 9173);
  EXPECT_THAT(open_folder(folder, small_camera())->info().warnings, warns_of("scale is probably wrong", "6553.5"));
}

TEST(Plausibility, IntrinsicsInAnotherOrderAreRecognised) {
  const TempFolder folder;
  write_slope(folder / "0.png", 1000, 640, 480);
  SequenceOptions options;
  options.intrinsics = Pinhole{525, 319.5f, 525, 239.5f, 0, 0};
  EXPECT_THAT(open_folder(folder, options)->info().warnings,
              warns_of("another order", "--intrinsics 525,525,319.5,239.5"));
  EXPECT_TRUE(other_order({319.5f, 239.5f, 525, 525, 640, 480}));
  EXPECT_FALSE(other_order({525, 525, 319.5f, 239.5f, 640, 480}));
  EXPECT_FALSE(other_order({481.2f, -480, 319.5f, 239.5f, 640, 480}));
}

TEST(Plausibility, StampsThatAreAllEqualLoseNoFrames) {
  const TempFolder folder;
  write_tum(folder, 5000, "0.000000");
  const auto sequence = open_folder(folder);
  EXPECT_EQ(sequence->size(), 6);
  EXPECT_THAT(sequence->info().warnings, warns_of("same stamp", "depth.txt"));
}

/// The warnings of six frames at these stamps.
std::vector<Warning> warnings_at(const std::vector<std::string>& stamps) {
  const TempFolder folder;
  std::string list;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    const std::string name = "depth/" + std::to_string(i) + ".png";
    write_slope(folder / name, 7500, 640, 480);
    list += stamps[i] + " " + name + "\n";
  }
  write_text(folder / "depth.txt", list);
  return open_folder(folder)->info().warnings;
}

TEST(Plausibility, StampsThatJump) {
  EXPECT_THAT(
      warnings_at({"1", "1.03", "1.06", "4.56", "4.6", "4.63"}),
      warns_of("jump 1 time by more than 1 s, at most by 3.50 s between frames 2 and 3, 0.06 s after", "Tracking"));
  EXPECT_THAT(warnings_at({"1", "1.5", "2", "2.5", "5", "5.5"}), IsEmpty()) << "slow, and one frame lost";
}

TEST(Plausibility, StampsThatRunBackwardsOrAreDoubled) {
  EXPECT_THAT(warnings_at({"1", "1.03", "1.06", "0.5", "0.53", "0.56"}),
              warns_of("run backwards in 1 place (3.png is 0.56 s before", "one clock"));
  EXPECT_THAT(warnings_at({"1", "1.03", "1.03", "1.06", "1.09", "1.12"}),
              warns_of("1 of the 6 depth images have the stamp of an earlier one", "own time"));
}

TEST(Plausibility, StampsInAnotherUnit) {
  EXPECT_THAT(warnings_at({"0", "33", "66", "100", "133", "166"}), warns_of("taken for milliseconds", "in seconds"));
  EXPECT_THAT(warnings_at({"0", "33333", "66666", "100000", "133333", "166666"}),
              warns_of("taken for microseconds", ""));
  EXPECT_THAT(warnings_at({"1721362630651355000", "1721362630684688000", "1721362630718021000"}),
              warns_of("depth.txt are taken for nanoseconds, by their size", ""));
}

TEST(Plausibility, RealSequencesAddUp) {
  for (const char* name : {"tum/rgbd_dataset_freiburg1_xyz", "tum/rgbd_dataset_freiburg1_rpy_head",
                           "tum/rgbd_dataset_freiburg1_desk_9frames", "icl_nuim/office_kt3"}) {
    PLUMBLINE_DATA_OR_SKIP(path, name);
    EXPECT_THAT(open_sequence(path.string())->info().warnings, IsEmpty()) << name;
  }
}

// ---- A bad frame costs that frame

TEST(ReadableFrames, ABadFrameIsSkippedAndNamed) {
  const TempFolder folder;
  write_tum(folder, 5000);
  write_text(folder / "depth/0.png", "");
  write_text(folder / "depth/3.png", "");
  const auto sequence = open_folder(folder);
  ReadableFrames frames(*sequence, {0, 1, 2, 3, 4, 5});
  std::vector<int> read;
  while (const auto frame = frames.next()) read.push_back(frame->index);
  EXPECT_EQ(read, (std::vector<int>{1, 2, 4, 5}));
  ASSERT_EQ(frames.skipped().size(), 2u);
  EXPECT_THAT(frames.skipped()[1], HasSubstr("3.png"));
}

TEST(ReadableFrames, StopsWhereMostAreBad) {
  const TempFolder folder;
  write_tum(folder, 5000);
  for (const int i : {0, 2, 3, 5}) write_text(folder / ("depth/" + std::to_string(i) + ".png"), "");
  const auto sequence = open_folder(folder);
  ReadableFrames frames(*sequence, {0, 1, 2, 3, 4, 5});
  EXPECT_THAT(error_of([&] {
                while (frames.next()) {
                }
              }),
              HasSubstr("0.png"));
}

// ---- Files with a camera

TEST(RecordedCamera, EachKindOfFile) {
  const TempFolder folder;
  write_text(folder / "a.txt", "50 0 31 0\n0 51 23 0\n0 0 1 0\n0 0 0 1\n");
  EXPECT_EQ(read_text_camera(folder / "a.txt").choice.camera, (Pinhole{50, 51, 31, 23, 0, 0}));
  write_text(folder / "b.txt", "50 51 31 23\n");
  EXPECT_EQ(read_text_camera(folder / "b.txt").choice.camera, (Pinhole{50, 51, 31, 23, 0, 0}));
  write_text(folder / "info.txt",
             "m_colorWidth = 128\nm_depthWidth = 64\nm_depthHeight = 48\nm_depthShift = 4000\n"
             "m_calibrationDepthIntrinsic = 50 0 31 0 0 51 23 0 0 0 1 0 0 0 0 1\n");
  const RecordedCamera info = read_info_camera(folder / "info.txt");
  EXPECT_EQ(info.choice.camera, (Pinhole{50, 51, 31, 23, 64, 48}));
  EXPECT_EQ(info.depth_scale, 4000);
  write_text(
      folder / "o.yaml",
      "%YAML:1.0\nCamera.fx: 50.0\nCamera.fy: 51.0 # pixels\nCamera.cx: 31\nCamera.cy: 23\nDepthMapFactor: 5208\n");
  const RecordedCamera orb = read_yaml_camera(folder / "o.yaml");
  EXPECT_EQ(orb.choice.camera, (Pinhole{50, 51, 31, 23, 0, 0}));
  EXPECT_EQ(orb.depth_scale, 5208);
  write_text(folder / "c.json", "{\"intrinsic_matrix\": [1, 2]}");
  EXPECT_THAT(error_of([&] { read_json_camera(folder / "c.json"); }), HasSubstr("c.json"));
  write_text(folder / "c.json", "{");
  EXPECT_THAT(error_of([&] { read_json_camera(folder / "c.json"); }), HasSubstr("c.json"));
}

TEST(UnreadFormats, AreNamedWithTheWayToConvertThem) {
  const TempFolder folder;
  for (const char* name : {"scan.oni", "scan.klg", "scan.r3d", "scan.xef", "scan.svo"}) {
    write_text(folder / name, "what such a file begins with");
    EXPECT_THAT(error_of([&] { open_sequence(folder / name); }),
                AllOf(HasSubstr("export"), HasSubstr("which is not read")))
        << name;
  }
}

}  // namespace
}  // namespace plumbline
