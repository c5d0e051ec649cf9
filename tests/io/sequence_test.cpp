#include "plumbline/sequence.h"
#include "plumbline/trajectory.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <thread>

#include "io/images/png.h"
#include "io/png_samples.h"
#include "io/trajectory.h"
#include "plumbline/frame.h"
#include "plumbline/image.h"
#include "plumbline/pinhole.h"
#include "support/data.h"
#include "support/error_of.h"
#include "support/temp_folder.h"

namespace plumbline {
namespace {

using test::error_of;
using test::read_text;
using test::TempFolder;
using test::write_text;
using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
namespace fs = std::filesystem;

constexpr int kWidth = 64, kHeight = 48;
const Pinhole kSmallCamera{50, 50, 31.5f, 23.5f, 0, 0};

SequenceOptions with_camera() {
  SequenceOptions options;
  options.intrinsics = kSmallCamera;
  return options;
}

DepthImage flat_depth(std::uint16_t value, int width = kWidth, int height = kHeight) {
  DepthImage depth(width, height);
  std::fill(depth.pixels.begin(), depth.pixels.end(), value);
  return depth;
}

void write_depth(const fs::path& path, std::uint16_t value, int width = kWidth, int height = kHeight) {
  fs::create_directories(path.parent_path());
  write_depth_png(path.string(), flat_depth(value, width, height));
}

void write_color(const fs::path& path, std::uint8_t value, int width = kWidth, int height = kHeight) {
  fs::create_directories(path.parent_path());
  ColorImage color(width, height, 3);
  std::fill(color.pixels.begin(), color.pixels.end(), value);
  write_color_png(path.string(), color);
}

/// Depth images a.png … whose first reading tells them apart: a.png has 1000, b.png 1001, …
void write_letters(const TempFolder& folder, int n) {
  for (int i = 0; i < n; ++i)
    write_depth(folder / (std::string("depth/") + static_cast<char>('a' + i) + ".png"),
                static_cast<std::uint16_t>(1000 + i));
}

int letter(const Frame& frame) { return frame.depth.pixels.front() - 1000; }

std::vector<std::string> notes_of(const TempFolder& folder) {
  return open_sequence(folder.path().string(), with_camera())->info().notes;
}

std::string open_error(const std::string& path, const SequenceOptions& options = with_camera()) {
  return error_of([&] { open_sequence(path, options); });
}

// ---- TUM
// -------------------------------------------------------------------------------------------------------------

TEST(TumSequence, ReadsAListWithCommentsAndCrLf) {
  const TempFolder folder;
  write_letters(folder, 3);
  write_text(
      folder / "depth.txt",
      "# depth maps\r\n# timestamp filename\r\n\r\n1.000001 depth/a.png\r\n1.1\tdepth/b.png\r\n  1.2 depth/c.png  ");
  write_text(folder / "groundtruth.txt", "1 0 0 0 0 0 0 1\n");
  const auto sequence = open_sequence(folder.path().string(), with_camera());
  const SequenceInfo& info = sequence->info();
  EXPECT_EQ(info.format, "TUM RGB-D");
  EXPECT_EQ(info.frames, 3);
  EXPECT_EQ(info.color_frames, 0);
  EXPECT_EQ(info.depth_scale, 5000);
  EXPECT_EQ(info.camera.width, kWidth);
  EXPECT_EQ(info.camera_source, "given intrinsics");
  EXPECT_EQ(info.first_time, 1000001000);
  EXPECT_EQ(info.last_time, 1200000000);
  EXPECT_EQ(info.groundtruth, folder / "groundtruth.txt");
  EXPECT_THAT(info.notes, IsEmpty());
  for (int i = 0; i < 3; ++i) {
    const Frame frame = sequence->read(i);
    EXPECT_EQ(frame.index, i);
    EXPECT_EQ(frame.time, sequence->time(i));
    EXPECT_EQ(frame.depth_scale, 5000);
    EXPECT_EQ(letter(frame), i);
    EXPECT_TRUE(frame.color.empty());
  }
  EXPECT_THROW(sequence->read(3), Error);
  EXPECT_THROW(sequence->read(-1), Error);
}

TEST(TumSequence, SortsAndThinsTheList) {
  const TempFolder folder;
  write_letters(folder, 4);
  write_text(folder / "depth.txt", "1.2 depth/c.png\n1.0 depth/a.png\n1.0 depth/d.png\n1.1 depth/b.png\n");
  const auto sequence = open_sequence(folder.path().string(), with_camera());
  ASSERT_EQ(sequence->size(), 3);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(letter(sequence->read(i)), i);
  EXPECT_THAT(sequence->info().warnings[0].what,
              AllOf(HasSubstr("run backwards in 1 place (a.png is 0.2 s before"), HasSubstr("sorted")));
  EXPECT_THAT(sequence->info().warnings[1].what, HasSubstr("1 of the 4 depth images have the stamp of an earlier one"));
}

TEST(TumSequence, HalfWrittenLastLineIsLeftOut) {
  for (const char* end : {"1.1", "1.1\n", "1.1 "}) {
    const TempFolder folder;
    write_letters(folder, 1);
    write_text(folder / "depth.txt", std::string("1.0 depth/a.png\n") + end);
    const auto sequence = open_sequence(folder.path().string(), with_camera());
    EXPECT_EQ(sequence->size(), 1);
    EXPECT_THAT(sequence->info().notes, ElementsAre(HasSubstr("half-written")));
  }
}

TEST(TumSequence, MalformedListsAreErrors) {
  const TempFolder folder;
  write_letters(folder, 2);
  write_text(folder / "depth.txt", "# c\n1.0 depth/a.png\n1.1\n1.2 depth/b.png\n");
  EXPECT_THAT(open_error(folder.path().string()), AllOf(HasSubstr("depth.txt:3"), HasSubstr("no file name")));
  write_text(folder / "depth.txt", "1.0 depth/a.png\none depth/b.png\n");
  EXPECT_THAT(open_error(folder.path().string()), AllOf(HasSubstr("depth.txt:2"), HasSubstr("'one'")));
  for (const char* nothing : {"", "# only a comment\n", "1.0\n"}) {
    write_text(folder / "depth.txt", nothing);
    EXPECT_THAT(open_error(folder.path().string()), HasSubstr("lists no depth images"));
  }
}

TEST(TumSequence, MissingFilesAreLeftOutAndToldOf) {
  const TempFolder folder;
  write_letters(folder, 2);
  write_text(folder / "depth.txt", "1.0 depth/a.png\n1.1 depth/x.png\n1.2 depth/b.png\n1.3 depth/half");
  const auto sequence = open_sequence(folder.path().string(), with_camera());
  EXPECT_EQ(sequence->size(), 2);
  EXPECT_EQ(letter(sequence->read(1)), 1);
  EXPECT_THAT(sequence->info().notes, ElementsAre(HasSubstr("2 of the 4 listed depth images are missing")));
  fs::remove_all(folder / "depth");
  EXPECT_THAT(open_error(folder.path().string()), HasSubstr("none of the 4 listed depth images is there"));
}

TEST(TumSequence, LongGapsAreToldOf) {
  const TempFolder folder;
  write_letters(folder, 4);
  write_text(folder / "depth.txt", "1.0 depth/a.png\n1.5 depth/b.png\n2.1 depth/c.png\n4.1 depth/d.png\n");
  EXPECT_THAT(notes_of(folder), ElementsAre(AllOf(HasSubstr("2 gaps"), HasSubstr("2.00 s after frame 2"))));
}

TEST(TumSequence, AssociatesNearestFirstAndOneToOne) {
  const TempFolder folder;
  write_letters(folder, 4);
  for (int i = 0; i < 4; ++i)
    write_color(folder / ("rgb/" + std::to_string(i) + ".png"), static_cast<std::uint8_t>(10 * i));
  write_text(folder / "depth.txt", "1.000 depth/a.png\n1.010 depth/b.png\n1.100 depth/c.png\n1.200 depth/d.png\n");
  // 0 is nearest to b although a comes first; a then takes 1; c's only candidate is exactly 20 ms off; d has none.
  write_text(folder / "rgb.txt", "1.009 rgb/0.png\n0.985 rgb/1.png\n1.120 rgb/2.png\n1.221 rgb/3.png\n");
  const auto sequence = open_sequence(folder.path().string(), with_camera());
  EXPECT_EQ(sequence->info().color_frames, 3);
  EXPECT_EQ(sequence->read(0).color.pixels[0], 10);
  EXPECT_EQ(sequence->read(1).color.pixels[0], 0);
  EXPECT_EQ(sequence->read(2).color.pixels[0], 20);
  EXPECT_TRUE(sequence->read(3).color.empty());
  EXPECT_THAT(sequence->info().notes, Contains(HasSubstr("1 of 4 depth images have no colour image within 0.02 s")));

  SequenceOptions options = with_camera();
  options.max_time_difference = 0.005;
  EXPECT_EQ(open_sequence(folder.path().string(), options)->info().color_frames, 1);
  options.color = false;
  EXPECT_EQ(open_sequence(folder.path().string(), options)->info().color_frames, 0);
  options.color = true;
  options.max_time_difference = std::nan("");
  EXPECT_THAT(open_error(folder.path().string(), options), HasSubstr("max_time_difference"));
}

TEST(TumSequence, GoesOnWithoutColorThatCannotBeUsed) {
  const TempFolder folder;
  write_letters(folder, 1);
  write_text(folder / "depth.txt", "1.0 depth/a.png\n");
  write_text(folder / "rgb.txt", "1.0 rgb/a.png\n");
  EXPECT_THAT(notes_of(folder), ElementsAre(HasSubstr("none of the 1 listed colour images is there")));
  write_color(folder / "rgb/a.png", 5, 128, 96);
  const auto sequence = open_sequence(folder.path().string(), with_camera());
  EXPECT_EQ(sequence->info().color_frames, 0);
  EXPECT_TRUE(sequence->read(0).color.empty());
  EXPECT_THAT(sequence->info().notes, ElementsAre(HasSubstr("128x96")));
}

TEST(TumSequence, ReadsAssociationsInEitherOrder) {
  for (const bool depth_first : {true, false}) {
    const TempFolder folder;
    write_letters(folder, 2);
    write_color(folder / "rgb/a.png", 40);
    std::string text;
    for (const char name : {'a', 'b'}) {
      const std::string depth = std::string("1.") + (name == 'a' ? "5" : "7") + " depth/" + name + ".png";
      const std::string color = std::string("1.51 rgb/") + name + ".png";
      text += depth_first ? depth + " " + color + "\n" : color + " " + depth + "\n";
    }
    write_text(folder / "associations.txt", text);
    const auto sequence = open_sequence(folder.path().string(), with_camera());
    EXPECT_EQ(sequence->info().format, "TUM RGB-D");
    ASSERT_EQ(sequence->size(), 2);
    EXPECT_EQ(sequence->time(0), 1500000000);
    EXPECT_EQ(sequence->read(0).color.pixels[0], 40);
    EXPECT_EQ(letter(sequence->read(1)), 1);
    EXPECT_EQ(sequence->info().color_frames, 1);
    EXPECT_THAT(sequence->info().notes, ElementsAre(HasSubstr("1 of the 2 listed colour images are missing")));
  }
}

TEST(TumSequence, MalformedAssociationsAreErrors) {
  const TempFolder folder;
  write_letters(folder, 2);
  const std::string good = "1.0 depth/a.png 1.0 rgb/a.png\n";
  write_text(folder / "associations.txt", "1.0 depth/a.png\n" + good);
  EXPECT_THAT(open_error(folder.path().string()), AllOf(HasSubstr("associations.txt:1"), HasSubstr("2 fields")));
  write_text(folder / "associations.txt", "1.0 one/a.png 1.0 two/a.png\n" + good);
  EXPECT_THAT(open_error(folder.path().string()), HasSubstr("cannot be told"));
  write_text(folder / "associations.txt", good + "1.0 depth/b.png 1.0 rg");
  EXPECT_EQ(open_sequence(folder.path().string(), with_camera())->size(), 1) << "same stamp: dropped";
  write_text(folder / "associations.txt", good + "1.1 depth/b.png 1");
  EXPECT_THAT(notes_of(folder), Contains(HasSubstr("half-written")));
}

// ---- Cameras
// ---------------------------------------------------------------------------------------------------------

/// A folder of the given name with one TUM frame of 640×480.
fs::path make_tum(const fs::path& folder, int width = 640, int height = 480) {
  write_depth(folder / "depth/a.png", 5000, width, height);
  write_text(folder / "depth.txt", "1.0 depth/a.png\n");
  return folder;
}

float fx_of(const fs::path& path, const SequenceOptions& options = {}) {
  return open_sequence(path.string(), options)->info().camera.fx;
}

TEST(SequenceCamera, IsFoundInTheFoldersName) {
  const TempFolder folder;
  const fs::path fr1 = make_tum(folder.path() / "rgbd_dataset_freiburg1_desk");
  const auto sequence = open_sequence(fr1.string());
  const SequenceInfo& info = sequence->info();
  EXPECT_EQ(info.camera, (Pinhole{517.3f, 516.5f, 318.6f, 255.3f, 640, 480}));
  EXPECT_EQ(info.distortion, (Distortion{0.2624, -0.9531, -0.0054, 0.0026, 1.1633}));
  EXPECT_THAT(info.camera_source, HasSubstr("freiburg1 in the folder's name"));
  EXPECT_THAT(info.notes, IsEmpty());
  EXPECT_EQ(fx_of(make_tum(folder.path() / "rgbd_dataset_freiburg2_xyz")), 520.9f);
  EXPECT_EQ(fx_of(make_tum(folder.path() / "x_Freiburg3_y")), 535.4f);
  EXPECT_EQ(fx_of(make_tum(folder.path() / "fr2_desk")), 520.9f);
  EXPECT_EQ(fx_of(make_tum(folder.path() / "afr2desk")), 525.0f) << "only a word of its own is a name";
}

TEST(SequenceCamera, IsFoundThroughLinksSlashesAndDots) {
  const TempFolder folder;
  const fs::path fr2 = make_tum(folder.path() / "rgbd_dataset_freiburg2_desk");
  fs::create_directory_symlink(fr2, folder.path() / "current");
  fs::create_directory_symlink(fr2, folder.path() / "freiburg3_alias");
  EXPECT_EQ(fx_of(fr2.string() + "/"), 520.9f);
  EXPECT_EQ(fx_of(fr2 / "."), 520.9f);
  EXPECT_EQ(fx_of(fr2 / "depth/.."), 520.9f);
  EXPECT_EQ(fx_of(folder.path() / "current"), 520.9f);
  EXPECT_EQ(fx_of(folder.path() / "current/"), 520.9f);
  EXPECT_EQ(fx_of(folder.path() / "freiburg3_alias"), 535.4f) << "the name that was given counts first";
  const fs::path before = fs::current_path();
  fs::current_path(fr2);
  EXPECT_EQ(fx_of("."), 520.9f);
  fs::current_path(before);
}

TEST(SequenceCamera, OrderOfSources) {
  const TempFolder folder;
  const fs::path path = make_tum(folder.path() / "freiburg1_x");
  EXPECT_EQ(fx_of(path), 517.3f);
  write_text(path / "camera-intrinsics.txt", "600 0 320\n0 601 240\n0 0 1\n");
  const auto from_file = open_sequence(path.string());
  EXPECT_EQ(from_file->info().camera, (Pinhole{600, 601, 320, 240, 640, 480}));
  EXPECT_TRUE(from_file->info().distortion.is_zero());
  EXPECT_THAT(from_file->info().camera_source, HasSubstr("camera-intrinsics.txt"));
  SequenceOptions options;
  options.camera = "icl";
  EXPECT_EQ(open_sequence(path.string(), options)->info().camera.fy, -480.0f);
  options.camera = "freiburg2";
  EXPECT_EQ(fx_of(path, options), 520.9f);
  options.intrinsics = Pinhole{700, 700, 320, 240, 0, 0};
  EXPECT_EQ(fx_of(path, options), 700);
  options.intrinsics.reset();
  options.distortion = Distortion{0.1, 0, 0, 0, 0};
  EXPECT_EQ(open_sequence(path.string(), options)->info().distortion.k1, 0.1);
  options.camera = "nikon";
  EXPECT_THAT(open_error(path.string(), options), AllOf(HasSubstr("'nikon'"), HasSubstr("fr1, fr2, fr3")));
}

TEST(SequenceCamera, NamesAreAllKnown) {
  const TempFolder folder;
  const fs::path path = make_tum(folder.path() / "some");
  EXPECT_EQ(camera_names().size(), 7u);
  for (const std::string& name : camera_names()) {
    SequenceOptions options;
    options.camera = name;
    EXPECT_TRUE(open_sequence(path.string(), options)->info().camera.is_valid()) << name;
  }
}

TEST(SequenceCamera, AGuessIsToldOf) {
  const TempFolder folder;
  const auto sequence = open_sequence(make_tum(folder.path() / "mine").string());
  EXPECT_EQ(sequence->info().camera.fx, 525.0f);
  EXPECT_THAT(sequence->info().notes, ElementsAre(HasSubstr("the camera is not known")));
}

TEST(SequenceCamera, ImpossibleIntrinsicsAreErrors) {
  const TempFolder folder;
  const std::string path = make_tum(folder.path() / "mine").string();
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();
  for (const Pinhole bad :
       {Pinhole{kNan, 500, 320, 240, 0, 0}, Pinhole{500, kInf, 320, 240, 0, 0}, Pinhole{0, 500, 320, 240, 0, 0},
        Pinhole{500, 0, 320, 240, 0, 0}, Pinhole{-500, 500, 320, 240, 0, 0}, Pinhole{500, 500, kNan, 240, 0, 0}}) {
    SequenceOptions options;
    options.intrinsics = bad;
    EXPECT_THAT(open_error(path, options), HasSubstr("not those of a camera"));
  }
  SequenceOptions options;
  options.camera = "icl";
  options.distortion = Distortion{0, 0, std::nan(""), 0, 0};
  EXPECT_THAT(open_error(path, options), HasSubstr("distortion"));
  options = {};
  for (const double scale : {0.0, -1.0, std::nan("")}) {
    options.depth_scale = scale;
    EXPECT_THAT(open_error(path, options), HasSubstr("depth scale"));
  }
}

TEST(SequenceCamera, AnotherImageSizeIsAnError) {
  const TempFolder folder;
  const std::string path = make_tum(folder.path() / "freiburg1_half", 320, 240).string();
  EXPECT_THAT(open_error(path, {}), AllOf(HasSubstr("640x480"), HasSubstr("320x240")));
  SequenceOptions options;
  options.intrinsics = Pinhole{517.3f, 516.5f, 318.6f, 255.3f, 0, 0};
  EXPECT_THAT(open_error(path, options), AllOf(HasSubstr("principal point"), HasSubstr("another size")));
  options.intrinsics->width = 640;
  EXPECT_THAT(open_error(path, options), HasSubstr("640x"));
  options.intrinsics = Pinhole{258, 258, 159.3f, 127.6f, 320, 240};
  EXPECT_EQ(fx_of(path, options), 258);
}

TEST(SequenceCamera, MalformedIntrinsicsFileIsAnError) {
  const TempFolder folder;
  const fs::path path = make_tum(folder.path() / "mine");
  const auto error = [&](const char* text) {
    write_text(path / "camera-intrinsics.txt", text);
    return open_error(path.string(), {});
  };
  EXPECT_THAT(error("600 0 320\n0 x 240\n0 0 1\n"), AllOf(HasSubstr("camera-intrinsics.txt:2"), HasSubstr("'x'")));
  EXPECT_THAT(error("600 0 320\n0 600 240\n"), HasSubstr("6 numbers"));
  EXPECT_THAT(error("600 5 320\n0 600 240\n0 0 1\n"), HasSubstr("without skew"));
  EXPECT_THAT(error("600 0 320\n0 nan 240\n0 0 1\n"), HasSubstr("finite"));
}

// ---- ICL-NUIM
// --------------------------------------------------------------------------------------------------------

TEST(IclSequence, IsToldByItsIntegerStamps) {
  const TempFolder folder;
  const fs::path path = folder.path() / "unnamed";
  std::string list;
  for (const int k : {1, 2, 10, 3}) {
    write_depth(path / ("depth/" + std::to_string(k) + ".png"), static_cast<std::uint16_t>(1000 + k), 640, 480);
    list += std::to_string(k) + " depth/" + std::to_string(k) + ".png " + std::to_string(k) + " rgb/" +
            std::to_string(k) + ".png\n";
  }
  write_color(path / "rgb/2.png", 77, 640, 480);
  write_text(path / "associations.txt", list);
  const auto sequence = open_sequence(path.string());
  const SequenceInfo& info = sequence->info();
  EXPECT_EQ(info.format, "ICL-NUIM");
  EXPECT_EQ(info.camera, (Pinhole{481.20f, -480.00f, 319.5f, 239.5f, 640, 480}));
  EXPECT_EQ(info.depth_scale, 5000);
  ASSERT_EQ(info.frames, 4);
  EXPECT_EQ(info.last_time, 10 * kNanosecondsPerSecond);
  EXPECT_EQ(letter(sequence->read(3)), 10);
  EXPECT_EQ(sequence->read(1).color.pixels[0], 77);
  EXPECT_THAT(info.notes, Not(Contains(HasSubstr("gap")))) << "the stamps count frames";
}

TEST(IclSequence, WithoutAListIsToldByItsName) {
  for (const char* name : {"living_room_traj2", "office_kt1", "icl-0", "traj3_frei_png"}) {
    const TempFolder folder;
    for (const int k : {10, 2, 0})
      write_depth(folder.path() / name / "depth" / (std::to_string(k) + ".png"), static_cast<std::uint16_t>(1000 + k),
                  640, 480);
    write_color(folder.path() / name / "rgb/2.png", 9, 640, 480);
    write_text(folder.path() / name / "traj2.gt.freiburg", "0 0 0 0 0 0 0 1\n");
    const auto sequence = open_sequence((folder.path() / name).string());
    EXPECT_EQ(sequence->info().format, "ICL-NUIM") << name;
    ASSERT_EQ(sequence->size(), 3);
    EXPECT_EQ(sequence->time(2), 10 * kNanosecondsPerSecond);
    EXPECT_EQ(letter(sequence->read(1)), 2);
    EXPECT_EQ(sequence->info().color_frames, 1);
    EXPECT_THAT(sequence->info().groundtruth, HasSubstr("traj2.gt.freiburg"));
  }
}

TEST(IclSequence, OtherNamesAreNotTaken) {
  for (const char* name : {"vehicle", "trajectory_1", "my_article"}) {
    const TempFolder folder;
    EXPECT_EQ(open_sequence(make_tum(folder.path() / name).string())->info().format, "TUM RGB-D") << name;
  }
}

// ---- 7-Scenes
// --------------------------------------------------------------------------------------------------------

fs::path make_seven_scenes(const fs::path& folder) {
  for (const int k : {0, 1, 3}) {
    const std::string name = "frame-00000" + std::to_string(k);
    DepthImage depth = flat_depth(static_cast<std::uint16_t>(1000 + k), 640, 480);
    depth.at(5, 5) = 65535;
    depth.at(6, 6) = 0;
    fs::create_directories(folder);
    write_depth_png((folder / (name + ".depth.png")).string(), depth);
    write_text(folder / (name + ".pose.txt"), "1 0 0 " + std::to_string(k) + "\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  }
  write_color(folder / "frame-000001.color.png", 33, 640, 480);
  return folder;
}

TEST(SevenScenesSequence, ReadsFramesAndPoses) {
  const TempFolder folder;
  const auto sequence = open_sequence(make_seven_scenes(folder.path() / "seq-01").string());
  const SequenceInfo& info = sequence->info();
  EXPECT_EQ(info.format, "7-Scenes");
  EXPECT_EQ(info.camera, (Pinhole{585, 585, 320, 240, 640, 480}));
  EXPECT_EQ(info.depth_scale, 1000);
  EXPECT_EQ(info.color_frames, 1);
  ASSERT_EQ(info.frames, 3);
  EXPECT_EQ(info.last_time, 100000000);
  const Frame frame = sequence->read(1);
  EXPECT_EQ(frame.depth.at(5, 5), 0) << "65535 is no reading";
  EXPECT_EQ(frame.depth.at(6, 6), 0);
  EXPECT_EQ(frame.depth.at(7, 7), 1001);
  EXPECT_EQ(frame.color.pixels[0], 33);
  const Trajectory poses = read_trajectory(info.groundtruth);
  ASSERT_EQ(poses.size(), 3u);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(poses[i].time, sequence->time(i));
  EXPECT_EQ(poses[2].world_from_camera.translation().x(), 3);
}

TEST(SevenScenesSequence, AScenesOnlySequenceIsTaken) {
  const TempFolder folder;
  make_seven_scenes(folder.path() / "chess/seq-01");
  const auto sequence = open_sequence((folder.path() / "chess").string());
  EXPECT_EQ(sequence->size(), 3);
  EXPECT_THAT(sequence->info().notes, Contains(HasSubstr("seq-01")));
  make_seven_scenes(folder.path() / "chess/seq-02");
  EXPECT_THAT(open_error((folder.path() / "chess").string(), {}), HasSubstr("seq-01, seq-02"));
}

// ---- Plain folders
// ---------------------------------------------------------------------------------------------------

TEST(DepthFolder, CountsAsPeopleDo) {
  const TempFolder folder;
  for (const int k : {1, 2, 10, 100})
    write_depth(folder / ("d" + std::to_string(k) + ".png"), static_cast<std::uint16_t>(1000 + k));
  EXPECT_THAT(open_error(folder.path().string(), {}),
              AllOf(HasSubstr("intrinsics are not known"), HasSubstr("camera-intrinsics.txt")));
  const auto sequence = open_sequence(folder.path().string(), with_camera());
  EXPECT_EQ(sequence->info().format, "depth images");
  EXPECT_EQ(sequence->info().depth_scale, 1000);
  ASSERT_EQ(sequence->size(), 4);
  EXPECT_EQ(letter(sequence->read(1)), 2);
  EXPECT_EQ(letter(sequence->read(2)), 10);
  EXPECT_EQ(sequence->time(1), 33333333);
  EXPECT_EQ(sequence->time(3), 100000000);
  SequenceOptions options = with_camera();
  options.depth_scale = 5000;
  EXPECT_EQ(open_sequence(folder.path().string(), options)->read(0).depth_scale, 5000);
}

TEST(DepthFolder, DecimalNamesAreStamps) {
  const TempFolder folder;
  write_depth(folder / "1305031102.160407.png", 1000);
  write_depth(folder / "1305031102.25.png", 1001);
  const auto sequence = open_sequence(folder.path().string(), with_camera());
  EXPECT_EQ(sequence->time(0), 1305031102160407000);
  EXPECT_EQ(sequence->time(1), 1305031102250000000);
  write_depth(folder / "last.png", 1002);
  EXPECT_EQ(open_sequence(folder.path().string(), with_camera())->time(0), 0) << "not all names are stamps";
}

TEST(DepthFolder, WhatHoldsNoSequenceIsAnError) {
  const TempFolder folder;
  EXPECT_THAT(open_error(folder.path().string()), HasSubstr("no sequence that is known"));
  EXPECT_THAT(open_error(folder / "gone"), HasSubstr("no such folder"));
  write_text(folder / "file", "x");
  EXPECT_THAT(open_error(folder / "file"), HasSubstr("is no recording that can be read"));
}

// ---- Reading frames
// --------------------------------------------------------------------------------------------------

/// Four frames, of which `bad` replaces the third.
std::unique_ptr<Sequence> with_bad_frame(const TempFolder& folder, std::string_view bad) {
  for (const int k : {0, 1, 2, 3})
    write_depth(folder / (std::to_string(k) + ".png"), static_cast<std::uint16_t>(1000 + k));
  write_text(folder / "2.png", bad);
  return open_sequence(folder.path().string(), with_camera());
}

TEST(SequenceRead, ABadFrameIsAnErrorAndTheNextIsRead) {
  const TempFolder source;
  write_depth(source / "small.png", 7, 32, 24);
  write_depth(source / "good.png", 7);
  const std::string small = read_text(source / "small.png"), good = read_text(source / "good.png");
  const std::pair<std::string, const char*> cases[] = {
      {std::string(test::kGrey8), "16-bit grey"},
      {std::string(test::kRgb8), "16-bit grey"},
      {small, "is 32x24"},
      {good.substr(0, good.size() / 2), "truncated"},
      {"", "empty"},
      {"text", "neither a PNG"},
  };
  for (const auto& [bytes, message] : cases) {
    const TempFolder folder;
    const auto sequence = with_bad_frame(folder, bytes);
    EXPECT_EQ(letter(sequence->read(1)), 1);
    EXPECT_THAT(error_of([&] { sequence->read(2); }), AllOf(HasSubstr("2.png"), HasSubstr(message)));
    EXPECT_EQ(letter(sequence->read(3)), 3);
  }
}

TEST(SequenceRead, TheFirstImageIsCheckedOnOpening) {
  const TempFolder folder;
  write_color(folder / "0.png", 1);
  EXPECT_THAT(open_error(folder.path().string()), AllOf(HasSubstr("0.png"), HasSubstr("16-bit grey")));
}

TEST(SequenceRead, DepthWithoutAReadingIsFine) {
  const TempFolder folder;
  write_depth(folder / "0.png", 0);
  EXPECT_THAT(open_sequence(folder.path().string(), with_camera())->read(0).depth.pixels, Each(0));
}

TEST(SequenceRead, DamagedColorIsAnError) {
  const TempFolder folder;
  write_letters(folder, 2);
  write_color(folder / "rgb/a.png", 1);
  write_text(folder / "depth.txt", "1.0 depth/a.png\n1.1 depth/b.png\n");
  write_text(folder / "rgb.txt", "1.0 rgb/a.png\n1.1 rgb/b.png\n");
  write_text(folder / "rgb/b.png", read_text(folder / "rgb/a.png").substr(0, 60));
  const auto sequence = open_sequence(folder.path().string(), with_camera());
  EXPECT_FALSE(sequence->read(0).color.empty());
  EXPECT_THAT(error_of([&] { sequence->read(1); }), HasSubstr("rgb/b.png"));
  write_color(folder / "rgb/b.png", 1, 128, 96);
  EXPECT_THAT(error_of([&] { sequence->read(1); }), HasSubstr("is 128x96"));
}

TEST(SequenceRead, UndistortsUnlessToldNotTo) {
  const TempFolder folder;
  DepthImage depth(640, 480);
  for (int v = 0; v < 480; ++v)
    for (int u = 0; u < 640; ++u) depth.at(u, v) = static_cast<std::uint16_t>(20000 + 10 * u);
  write_depth_png(folder / "0.png", depth);
  SequenceOptions options;
  options.camera = "fr1";
  const Frame undistorted = open_sequence(folder.path().string(), options)->read(0);
  options.undistort = false;
  const Frame raw = open_sequence(folder.path().string(), options)->read(0);
  EXPECT_TRUE(raw.depth.pixels == depth.pixels);
  EXPECT_FALSE(undistorted.depth.pixels == depth.pixels);
  EXPECT_NEAR(undistorted.depth.at(319, 255), depth.at(319, 255), 15) << "near the principal point little moves";
}

// ---- Real data
// -------------------------------------------------------------------------------------------------------

TEST(RealSequence, Freiburg1Xyz) {
  PLUMBLINE_DATA_OR_SKIP(folder, "tum/rgbd_dataset_freiburg1_xyz");
  const auto sequence = open_sequence(folder.string());
  const SequenceInfo& info = sequence->info();
  EXPECT_EQ(info.format, "TUM RGB-D");
  EXPECT_EQ(info.frames, 798);
  EXPECT_EQ(info.color_frames, 0);
  EXPECT_EQ(info.first_time, 1305031102160407000);
  EXPECT_EQ(info.camera.fx, 517.3f);
  EXPECT_THAT(info.notes, Contains(HasSubstr("none of the 798 listed colour images")));
  EXPECT_GT(read_trajectory(info.groundtruth).size(), 2000u);
  const Frame frame = sequence->read(0);
  EXPECT_EQ(frame.depth.width, 640);
  const auto readings =
      std::count_if(frame.depth.pixels.begin(), frame.depth.pixels.end(), [](int d) { return d > 0; });
  EXPECT_GT(readings, 640 * 480 / 2);
}

TEST(RealSequence, Freiburg1DeskWithMissingFiles) {
  PLUMBLINE_DATA_OR_SKIP(folder, "tum/rgbd_dataset_freiburg1_desk_9frames");
  const auto sequence = open_sequence(folder.string());
  EXPECT_EQ(sequence->info().frames, 9);
  EXPECT_EQ(sequence->info().color_frames, 9);
  EXPECT_EQ(sequence->info().first_time, 1305031453374112000);
  EXPECT_THAT(sequence->info().notes,
              ElementsAre(HasSubstr("586 of the 595 listed depth"), HasSubstr("604 of the 613 listed colour")));
  for (int i = 0; i < 9; ++i) {
    const Frame frame = sequence->read(i);
    EXPECT_EQ(frame.color.width, 640);
    EXPECT_EQ(frame.color.channels, 3);
  }
}

TEST(RealSequence, IclOffice) {
  PLUMBLINE_DATA_OR_SKIP(folder, "icl_nuim/office_kt3");
  const auto sequence = open_sequence(folder.string());
  const SequenceInfo& info = sequence->info();
  EXPECT_EQ(info.format, "ICL-NUIM");
  EXPECT_EQ(info.frames, 100);
  EXPECT_EQ(info.color_frames, 100);
  EXPECT_EQ(info.camera.fy, -480.0f);
  EXPECT_EQ(sequence->time(0), kNanosecondsPerSecond);
  EXPECT_THAT(info.notes, ElementsAre(HasSubstr("taken for ICL-NUIM, a guess")));
  const Trajectory truth = read_trajectory(info.groundtruth);
  for (int i = 0; i < info.frames; ++i) EXPECT_EQ(truth[i].time, sequence->time(i));
  EXPECT_FALSE(sequence->read(50).color.empty());
}

TEST(RealSequence, ReadsAlikeInSeveralThreads) {
  PLUMBLINE_DATA_OR_SKIP(folder, "tum/rgbd_dataset_freiburg1_rpy_head");
  const auto sequence = open_sequence(folder.string());
  EXPECT_EQ(sequence->size(), 240);
  const Frame expected = sequence->read(7);
  std::vector<Frame> frames(4);
  std::vector<std::thread> threads;
  for (Frame& frame : frames) threads.emplace_back([&] { frame = sequence->read(7); });
  for (std::thread& thread : threads) thread.join();
  for (const Frame& frame : frames) EXPECT_TRUE(frame.depth.pixels == expected.depth.pixels);
}

}  // namespace
}  // namespace plumbline
