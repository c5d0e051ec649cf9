// Recordings that are not quite what a format says, as people have them: read for what they are, or plainly told.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <bit>
#include <cmath>
#include <filesystem>
#include <functional>

#include "io/imu_file.h"
#include "io/layout_samples.h"
#include "io/recorded_camera.h"
#include "plumbline/error.h"
#include "plumbline/frame.h"
#include "plumbline/sequence.h"
#include "support/error_of.h"
#include "support/temp_folder.h"

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

constexpr const char* kCameraJson = R"({"width": 64, "height": 48, "fx": 50, "fy": 50, "cx": 31.5, "cy": 23.5)";

void write_camera(const TempFolder& folder, const std::string& more = "") {
  write_text(folder / "camera_intrinsic.json", kCameraJson + more + "}");
}

void write_depths(const TempFolder& folder, int count, const std::function<std::string(int)>& name, int near = 1001) {
  for (int i = 0; i < count; ++i) write_slope(folder / name(i), near);
}

auto numbered(const std::string& pattern, int first = 0) {
  return [pattern, first](int i) { return fmt::format(fmt::runtime(pattern), i + first); };
}

// ---- Cameras and scales

TEST(UnusualCamera, ScalesOfManySpellings) {
  for (const auto& [more, scale] : {std::pair(R"(, "depth_scale": 4000)", 4000.0),
                                    {R"(, "depthScale": 5000)", 5000},
                                    {R"(, "depth_units": 0.00025)", 4000},
                                    {R"(, "depth_unit": "mm")", 1000},
                                    {R"(, "scale": 6553.5)", 6553.5}}) {
    const TempFolder folder;
    write_depths(folder, 2, numbered("depth/{}.png"), 4001);
    write_camera(folder, more);
    const auto sequence = open_folder(folder);
    EXPECT_EQ(sequence->info().depth_scale, scale) << more;
    EXPECT_FALSE(sequence->info().depth_scale_is_guess) << more;
  }
}

TEST(UnusualCamera, TheDepthCameraOfSeveralInOneFile) {
  const TempFolder folder;
  write_text(folder / "c.json", R"({"color": {"fx": 99, "fy": 99, "cx": 31, "cy": 23},
                                   "depth": {"fx": 50, "fy": 51, "ppx": 31, "ppy": 23, "depth_scale": 0.00025}})");
  const RecordedCamera camera = read_json_camera(folder / "c.json");
  EXPECT_EQ(camera.choice.camera, (Pinhole{50, 51, 31, 23, 0, 0}));
  EXPECT_EQ(camera.depth_scale, 4000);
}

TEST(UnusualCamera, YamlOfRosOpenCvAndKalibr) {
  const TempFolder folder;
  for (const char* text :
       {"image_width: 64\nimage_height: 48\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: [50, 0, 31, 0, 51, 23, 0, 0, "
        "1]\n",
        "%YAML:1.0\nimage_width: 64\nimage_height: 48\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: "
        "d\n"
        "   data: [ 50., 0., 31., 0.,\n       51., 23., 0., 0., 1. ]\n",
        "cam0:\n  camera_model: pinhole\n  intrinsics: [50, 51, 31, 23]\n  resolution: [64, 48]\n"}) {
    write_text(folder / "c.yaml", text);
    EXPECT_EQ(read_yaml_camera(folder / "c.yaml").choice.camera, (Pinhole{50, 51, 31, 23, 64, 48})) << text;
  }
  write_text(folder / "c.yaml", "intrinsics: [50, 51]\n");
  EXPECT_THAT(error_of([&] { read_yaml_camera(folder / "c.yaml"); }), HasSubstr("no camera_matrix"));
}

TEST(UnusualCamera, FilesThatContradictEachOther) {
  const TempFolder folder;
  write_depths(folder, 2, numbered("depth/{}.png"));
  write_camera(folder);
  write_text(folder / "intrinsics.txt", "60 60 31.5 23.5\n");
  EXPECT_THAT(open_folder(folder)->info().warnings,
              warns_of("camera_intrinsic.json tells fx 50 and intrinsics.txt tells fx 60", "Remove"));
  write_text(folder / "intrinsics.txt", "100 100 63.5 47.5\n");
  EXPECT_THAT(open_folder(folder)->info().warnings, IsEmpty()) << "the same camera at twice the size";
}

TEST(UnusualCamera, AFileThatCannotBeReadIsNoDeadEnd) {
  const TempFolder folder;
  write_depths(folder, 2, numbered("depth/{}.png"));
  write_text(folder / "intrinsics.json", "{\"note\": 1}");
  EXPECT_EQ(open_folder(folder, small_camera())->info().camera.fx, 50) << "given";
  write_text(folder / "intrinsics.txt", "50 50 31.5 23.5\n");
  EXPECT_THAT(open_folder(folder)->info().warnings, warns_of("intrinsics.json", "--intrinsics"));
}

TEST(UnusualCamera, TheMatrixOfLargerImagesIsScaledByItsCentre) {
  const TempFolder folder;
  write_depths(folder, 2, numbered("depth/{}.png"));
  write_text(folder / "intrinsics.txt", "1500 1500 955.5 721.5\n");
  const auto sequence = open_folder(folder);
  EXPECT_NEAR(sequence->info().camera.fx, 50, 1e-4);
  EXPECT_TRUE(sequence->info().camera_is_guess);
  EXPECT_THAT(sequence->info().camera_source, HasSubstr("a guess by its principal point"));
}

TEST(UnusualCamera, ColoursMatrixIsOfItsFullSize) {
  const TempFolder folder;
  for (int i = 0; i < 2; ++i) {
    write_slope(folder / fmt::format("depth/{}.png", i), 1001);
    write_color(folder / fmt::format("color/{}.png", i), 70);
  }
  fs::create_directories(folder.path() / "intrinsic");
  write_text(folder / "intrinsic/intrinsic_depth.txt", "50 0 31.5 0\n0 50 23.5 0\n0 0 1 0\n0 0 0 1\n");
  write_text(folder / "intrinsic/intrinsic_color.txt", "1500 0 959.5 0\n0 1500 719.5 0\n0 0 1 0\n0 0 0 1\n");
  const Frame frame = open_folder(folder)->read(1);
  EXPECT_EQ(frame.color.at(5, 5, 0), 70);
  EXPECT_EQ(frame.color.at(60, 40, 0), 70) << "as far as depth goes";
}

// ---- Depth

TEST(UnusualDepth, SwappedBytesAreTurned) {
  const TempFolder folder;
  write_camera(folder);
  for (int i = 0; i < 2; ++i) {
    DepthImage depth(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) depth.at(x, y) = std::rotr(static_cast<std::uint16_t>(1000 + 7 * x + y), 8);
    fs::create_directories(folder.path() / "depth");
    write_depth_png(folder / fmt::format("depth/{}.png", i), depth);
  }
  const auto sequence = open_folder(folder);
  EXPECT_EQ(sequence->read(0).depth.at(10, 3), 1073);
  EXPECT_THAT(sequence->info().warnings, warns_of("wrong order", "order of bytes"));
}

/// A slope whose left third has one value.
void write_marked(const fs::path& path, int marker) {
  DepthImage depth(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) depth.at(x, y) = static_cast<std::uint16_t>(x < 20 ? marker : 1000 + 7 * x + y);
  fs::create_directories(path.parent_path());
  write_depth_png(path.string(), depth);
}

TEST(UnusualDepth, AMarkOfNoReadingIsNotAWall) {
  const TempFolder folder;
  write_camera(folder);
  write_marked(folder / "depth/0.png", 4000);
  write_marked(folder / "depth/1.png", 4000);
  EXPECT_THAT(open_folder(folder)->info().warnings,
              ElementsAre(testing::Field(&Warning::what, HasSubstr("have the largest value, 4000 (4 m)"))));
  write_marked(folder / "depth/0.png", 65535);
  write_marked(folder / "depth/1.png", 65535);
  EXPECT_THAT(open_folder(folder)->info().warnings, IsEmpty()) << "what 16 bits cannot tell is no distance";
}

TEST(UnusualDepth, ImagesStretchedForViewing) {
  const TempFolder folder;
  write_camera(folder);
  for (int i = 0; i < 2; ++i) {
    DepthImage depth(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) depth.at(x, y) = static_cast<std::uint16_t>(65535 * x / (kWidth - 1));
    fs::create_directories(folder.path() / "depth");
    write_depth_png(folder / fmt::format("depth/{}.png", i), depth);
  }
  EXPECT_THAT(open_folder(folder)->info().warnings, warns_of("stretched for viewing", "as the camera wrote them"));
}

TEST(UnusualDepth, AToldScaleThatPutsARoomIntoAHandIsWarnedOf) {
  const TempFolder folder;
  write_camera(folder, R"(, "depth_scale": 5000)");
  write_depths(folder, 2, numbered("depth/{}.png"), 700);
  EXPECT_THAT(open_folder(folder)->info().warnings, warns_of("camera_intrinsic.json", "--depth-scale 1000"));
}

TEST(UnusualDepth, TheFolderWhoseImagesAreDepthIsTaken) {
  const TempFolder folder;
  write_camera(folder);
  for (int i = 0; i < 2; ++i) write_color(folder / fmt::format("depth/{}.png", i), 90);
  write_depths(folder, 2, numbered("depth_raw/{}.png"));
  const auto sequence = open_folder(folder);
  EXPECT_EQ(sequence->read(1).depth.at(0, 0), 1001);
  EXPECT_THAT(sequence->info().notes, Contains(HasSubstr("depth/ is not used")));
}

TEST(UnusualDepth, OneOfTwoCamerasInAFolder) {
  const TempFolder folder;
  write_camera(folder);
  write_depths(folder, 3, numbered("cam0_depth_{:03}.png"));
  write_depths(folder, 3, numbered("cam1_depth_{:03}.png"), 1501);
  const auto sequence = open_folder(folder);
  EXPECT_EQ(sequence->size(), 3);
  EXPECT_EQ(sequence->read(2).depth.at(0, 0), 1001);
  EXPECT_THAT(sequence->info().notes, Contains(HasSubstr("cam1_depth_000.png and the like are not used")));
}

TEST(UnusualDepth, MixedSizesAreThoseOfMost) {
  const TempFolder folder;
  write_text(folder / "camera_intrinsic.json", kCameraJson + std::string("}"));
  for (int i = 0; i < 36; ++i)
    write_slope(folder / fmt::format("depth/{:03}.png", i), 1001, i % 3 == 0 ? 32 : kWidth, i % 3 == 0 ? 24 : kHeight);
  EXPECT_EQ(open_folder(folder)->info().camera.width, kWidth);
}

// ---- Confidence

TEST(UnusualConfidence, OfAnotherSizeIsSampledOfAnotherShapeLeftOut) {
  const TempFolder folder;
  write_camera(folder);
  write_depths(folder, 2, numbered("depth/{}.png"));
  for (int i = 0; i < 2; ++i) write_color(folder / fmt::format("confidence/{}.png", i), 2, 32, 24);
  EXPECT_EQ(open_folder(folder)->read(0).depth.at(9, 9), 1000 + 1 + 2 * 1001 * 9 / kWidth);
  for (int i = 0; i < 2; ++i) write_color(folder / fmt::format("confidence/{}.png", i), 2, 32, 32);
  EXPECT_THAT(open_folder(folder)->info().notes, Contains(HasSubstr("confidence is not used")));
  for (int i = 0; i < 2; ++i) write_color(folder / fmt::format("confidence/{}.png", i), 0);
  EXPECT_THAT(open_folder(folder)->info().warnings, warns_of("100 % of the readings", "--min-confidence 0"));
}

// ---- Colour

TEST(UnusualColour, NumberedFromOneIsPairedInOrder) {
  const TempFolder folder;
  write_camera(folder);
  write_depths(folder, 4, numbered("depth/{:04}.png"));
  for (int i = 0; i < 4; ++i)
    write_color(folder / fmt::format("rgb/{:04}.png", i + 1), static_cast<std::uint8_t>(10 * i + 10));
  const auto sequence = open_folder(folder);
  EXPECT_EQ(sequence->info().color_frames, 4);
  EXPECT_EQ(sequence->read(2).color.at(0, 0, 0), 30);
  EXPECT_THAT(sequence->info().notes, Contains(HasSubstr("paired in order, a guess")));
}

TEST(UnusualColour, AtHalfTheRateIsWarnedOf) {
  const TempFolder folder;
  write_camera(folder);
  write_depths(folder, 6, numbered("depth/{:04}.png"));
  for (int i = 0; i < 3; ++i) write_color(folder / fmt::format("rgb/{:04}.png", i), 50);
  EXPECT_THAT(open_folder(folder)->info().warnings, warns_of("3 colour images", "same rate"));
}

/// Boxes before a wall, and what a colour camera sees of them whose focal length is `zoom` times the depth camera's.
void write_boxes(const TempFolder& folder, double zoom, bool mirrored) {
  constexpr int kWide = 160, kHigh = 120;
  for (int i = 0; i < 6; ++i) {
    const auto box_at = [&](double x, double y) {
      const auto cell_x = static_cast<int>(std::floor((x + 3 * i) / 17)), cell_y = static_cast<int>(std::floor(y / 13));
      return (cell_x * 7 + cell_y * 3) % 5 < 2;
    };
    DepthImage depth(kWide, kHigh);
    ColorImage color(kWide, kHigh, 3);
    for (int y = 0; y < kHigh; ++y)
      for (int x = 0; x < kWide; ++x) {
        depth.at(x, y) = box_at(x, y) ? 1207 : 2001;
        const double sign = mirrored ? -1 : 1;
        const double u = (x - 79.5) / zoom * sign + 79.5, v = (y - 59.5) / zoom + 59.5;
        for (int c = 0; c < 3; ++c) color.at(x, y, c) = box_at(u, v) ? 200 : 60;
      }
    fs::create_directories(folder.path() / "depth");
    fs::create_directories(folder.path() / "color");
    write_depth_png(folder / fmt::format("depth/{}.png", i), depth);
    write_color_png(folder / fmt::format("color/{}.png", i), color);
  }
  write_text(folder / "intrinsics.txt", "130 130 79.5 59.5\n");
}

TEST(UnusualColour, OfAnotherCameraIsSeenByItsEdges) {
  const TempFolder registered, zoomed, mirrored;
  write_boxes(registered, 1, false);
  EXPECT_THAT(open_folder(registered)->info().warnings, IsEmpty());
  write_boxes(zoomed, 1.6, false);
  EXPECT_THAT(open_folder(zoomed)->info().warnings, warns_of("colour seems not to lie on depth", "Register colour"));
  write_boxes(mirrored, 1, true);
  EXPECT_THAT(open_folder(mirrored)->info().warnings, warns_of("mirrored", "--no-color"));
}

// ---- Stamps and lists

TEST(UnusualStamps, TimesSince1970InNames) {
  for (const char* pattern :
       {"depth/1700000000{:03}.png", "depth/1700000000{:03}000.png", "depth/1700000000{:03}000000.png",
        "depth/depth_1700000000{:03}000000.png", "depth/1700000000_{:03}000000.png"}) {
    const TempFolder folder;
    write_camera(folder);
    write_depths(folder, 3, [&](int i) { return fmt::format(fmt::runtime(pattern), 100 * i); });
    const auto sequence = open_folder(folder);
    EXPECT_EQ(sequence->time(0), 1'700'000'000 * kNanosecondsPerSecond) << pattern;
    EXPECT_EQ(sequence->time(2) - sequence->time(1), kNanosecondsPerSecond / 10) << pattern;
  }
}

TEST(UnusualStamps, MillisecondsByTheirIntervalAndCountsOfFrames) {
  const TempFolder folder;
  write_camera(folder);
  std::string milliseconds, counts;
  for (int i = 0; i < 5; ++i) {
    write_slope(folder / fmt::format("depth/{}.png", i), 5001);
    milliseconds += fmt::format("{} depth/{}.png\n", 33 * i, i);
    counts += fmt::format("{} depth/{}.png\n", i, i);
  }
  write_text(folder / "depth.txt", milliseconds);
  EXPECT_EQ(open_folder(folder)->time(1) - open_folder(folder)->time(0), 33'000'000);
  EXPECT_THAT(open_folder(folder)->info().warnings, warns_of("milliseconds", "in seconds"));
  write_text(folder / "depth.txt", counts);
  EXPECT_NEAR(to_seconds(open_folder(folder)->time(1)), 1 / 30.0, 1e-6);
  EXPECT_THAT(open_folder(folder)->info().warnings, warns_of("count frames", "in seconds"));
  for (const char* truth : {"0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n", "0.000000 0 0 0 0 0 0 1\n1.000000 0 0 0 0 0 0 1\n"}) {
    write_text(folder / "groundtruth.txt", truth);
    EXPECT_EQ(open_folder(folder)->time(1), kNanosecondsPerSecond) << "the true poses count frames as well";
  }
}

TEST(UnusualLists, CommasBackslashesAndPathsOfAnotherMachine) {
  for (const char* line : {"{}.5,depth/{}.png\n", "{}.5 depth\\{}.png\n", "{}.5 /home/ada/scan/depth/{}.png\n"}) {
    const TempFolder folder;
    write_camera(folder);
    std::string list;
    for (int i = 0; i < 3; ++i) {
      write_slope(folder / fmt::format("depth/{}.png", i), 5001);
      list += fmt::format(fmt::runtime(line), i, i);
    }
    write_text(folder / "depth.txt", list);
    EXPECT_EQ(open_folder(folder)->size(), 3) << line;
  }
}

TEST(UnusualLists, AssociationsUnderOtherNames) {
  for (const char* name : {"associate.txt", "association.txt", "rgbd_assoc.txt"}) {
    const TempFolder folder;
    write_camera(folder);
    std::string list;
    for (int i = 0; i < 3; ++i) {
      write_slope(folder / fmt::format("depth/{}.png", i), 5001);
      write_color(folder / fmt::format("rgb/{}.png", i), 50);
      list += fmt::format("{}.25,rgb/{}.png,{}.5,depth/{}.png\n", i, i, i, i);
    }
    write_text(folder / name, list);
    EXPECT_EQ(open_folder(folder)->time(1), 3 * kNanosecondsPerSecond / 2) << name;
    EXPECT_EQ(open_folder(folder)->info().color_frames, 3) << name;
  }
}

// ---- Inertial readings

TEST(UnusualImu, FilesOfOtherNamesAndSeparators) {
  for (const char* name : {"imu.txt", "IMU_data.csv", "gyro.csv"}) {
    const TempFolder folder;
    write_text(folder / name,
               "timestamp;gyro_x;gyro_y;gyro_z;accelerometer_x;accelerometer_y;accelerometer_z\n"
               "1.00;0.1;0.2;0.3;0;0;9.8\n1.01;0.1;0.2;0.3;0;0;9.8\n");
    const std::string file = find_imu_file(folder.path().string());
    ASSERT_THAT(file, HasSubstr(name));
    EXPECT_NEAR(read_imu(file).samples[1].angular_rate.z(), 0.3, 1e-12);
  }
  const TempFolder folder;
  write_text(folder / "imu_notes.txt", "bought in May\n");
  EXPECT_THAT(find_imu_file(folder.path().string()), IsEmpty());
}

TEST(UnusualImu, UnitsOfARecordingsReadings) {
  ImuRecording recording;
  recording.has_gyroscope = recording.has_accelerometer = true;
  for (int i = 0; i < 400; ++i) {
    const double angle = 0.8 * std::sin(0.02 * i);
    recording.samples.push_back({from_seconds(0.01 * i),
                                 {0, 1.6 * std::cos(0.02 * i) * 180 / M_PI, 0},
                                 {-std::sin(angle), 0, std::cos(angle)}});
  }
  std::vector<std::string> notes;
  settle_units(&recording, &notes);
  EXPECT_NEAR(recording.samples[0].specific_force.norm(), 9.80665, 1e-9);
  EXPECT_NEAR(recording.samples[0].angular_rate.y(), 1.6, 1e-9);
  EXPECT_THAT(notes, AllOf(Contains(HasSubstr("taken for g")), Contains(HasSubstr("deg/s"))));
  notes.clear();
  settle_units(&recording, &notes);
  EXPECT_THAT(notes, IsEmpty()) << "now they are right";
}

TEST(UnusualFolders, WhatLiesThereAndIsNotUsedIsTold) {
  const TempFolder folder;
  write_camera(folder);
  write_depths(folder, 2, numbered("depth/{}.png"));
  for (const char* name : {"orientation.csv", "poses.txt", "rgb.mp4"}) write_text(folder / name, "1 0 0 0 1\n");
  EXPECT_THAT(open_folder(folder)->info().notes,
              AllOf(Contains(AllOf(HasSubstr("orientation.csv is not used"), HasSubstr("--orientation"))),
                    Contains(AllOf(HasSubstr("poses.txt is not used"), HasSubstr("--groundtruth"))),
                    Contains(HasSubstr("rgb.mp4 is not used"))));
}

// ---- What is no recording

TEST(NoRecording, SaysWhatThereIs) {
  const TempFolder folder;
  write_depths(folder, 2, numbered("kitchen/depth/{}.png"));
  write_text(folder / "kitchen/intrinsics.txt", "50 50 31.5 23.5\n");
  const auto only = open_folder(folder);
  EXPECT_THAT(only->info().notes, Contains(HasSubstr("the only recording in the folder, kitchen")));
  EXPECT_EQ(only->info().camera.fx, 50);
  write_depths(folder, 2, numbered("office/depth/{}.png"));
  EXPECT_THAT(error_of([&] { open_folder(folder); }), HasSubstr("holds 2 recordings: kitchen, office"));
}

TEST(NoRecording, NamesDisparityPackedFilesAndImages) {
  const TempFolder disparity, packed, image;
  write_depths(disparity, 2, numbered("disparity/{}.png"));
  EXPECT_THAT(error_of([&] { open_folder(disparity); }), HasSubstr("disparity images, which are not depth"));
  write_text(packed / "scan.zip", "PK");
  EXPECT_THAT(error_of([&] { open_folder(packed); }), HasSubstr("unpack it"));
  EXPECT_THAT(error_of([&] { open_sequence(packed / "scan.zip"); }), HasSubstr("unpack it"));
  write_slope(image / "depth.png", 1001);
  EXPECT_THAT(error_of([&] { open_sequence(image / "depth.png"); }), HasSubstr("a single image"));
}

}  // namespace
}  // namespace plumbline
