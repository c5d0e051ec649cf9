#include "capture/recorder.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <set>
#include <sstream>
#include <thread>

#include "capture/clock.h"
#include "io/images/image_file.h"
#include "plumbline/files.h"
#include "plumbline/frame.h"
#include "plumbline/image.h"
#include "plumbline/pinhole.h"
#include "plumbline/sequence.h"
#include "plumbline/time.h"
#include "support/error_of.h"
#include "support/small_disk.h"
#include "support/temp_folder.h"

namespace plumbline::capture {
namespace {

namespace fs = std::filesystem;
using test::TempFolder;
using testing::HasSubstr;

constexpr Pinhole kCamera{60, 60, 31.5f, 23.5f, 64, 48};
constexpr Nanoseconds kFrame = 33'000'000;

/// Noise, which does not compress.
CapturedFrame noisy_frame(int i, const Pinhole& camera = kCamera) {
  std::mt19937 random(static_cast<unsigned>(i));
  CapturedFrame frame{now() + i * kFrame, DepthImage(camera.width, camera.height), now() + i * kFrame + 1'000'000,
                      ColorImage(camera.width, camera.height, 3)};
  for (std::uint16_t& reading : frame.depth.pixels) reading = static_cast<std::uint16_t>(500 + random() % 4000);
  for (std::uint8_t& value : frame.color.pixels) value = static_cast<std::uint8_t>(random());
  return frame;
}

ImuReading reading_at(Nanoseconds time) {
  ImuReading reading;
  reading.time = time;
  reading.quaternion = Eigen::Vector4d(0.1, -0.2, 0.3, 0.9).normalized();
  reading.raw = RawReading{{0.1, 0.2, 0.3}, {0, 0, 9.81}, {20, 0, -44}};
  return reading;
}

RecorderOptions options_for(const std::string& folder) {
  RecorderOptions options;
  options.folder = folder;
  options.camera = kCamera;
  options.color = options.orientation = options.raw = true;
  options.queue = 100;
  return options;
}

/// Files that a list names.
std::vector<std::string> listed(const std::string& folder, const std::string& list) {
  std::istringstream text(test::read_text(fs::path(folder) / list));
  std::vector<std::string> files;
  for (std::string line; std::getline(text, line);)
    if (!line.starts_with('#')) files.push_back((fs::path(folder) / line.substr(line.find(' ') + 1)).string());
  return files;
}

TEST(Recorder, WritesAFolderThatTheReadersTake) {
  const TempFolder folder;
  Recorder recorder(options_for(folder / "rec"));
  const CapturedFrame first = noisy_frame(0);
  recorder.add(first);
  for (int i = 1; i < 10; ++i) recorder.add(noisy_frame(i));
  for (int i = 0; i < 30; ++i) recorder.add(reading_at(first.time + i * 10'000'000));
  recorder.finish();
  EXPECT_EQ(recorder.status().frames, 10u);
  EXPECT_EQ(recorder.status().dropped, 0u);

  const auto sequence = open_sequence(folder / "rec");
  ASSERT_EQ(sequence->size(), 10);
  EXPECT_EQ(sequence->info().color_frames, 10);
  EXPECT_EQ(sequence->info().camera, kCamera);
  EXPECT_TRUE(sequence->info().notes.empty());
  const Frame frame = sequence->read(0);
  EXPECT_EQ(frame.color.pixels, first.color.pixels);
  for (std::size_t i = 0; i < frame.depth.pixels.size(); ++i)  // millimetres to TUM's 5000 a metre
    ASSERT_EQ(frame.depth.pixels[i], 5 * first.depth.pixels[i]);
  // One clock for everything, to the microsecond.
  const auto orientations = read_orientations(folder / "rec/orientation.txt", {});
  ASSERT_EQ(orientations.size(), 30u);
  EXPECT_LE(std::abs(orientations[0].time - sequence->time(0)), 1000);
  const Eigen::Quaterniond q(orientations[0].earth_from_body);
  EXPECT_NEAR(std::abs(q.coeffs().dot(reading_at(0).quaternion)), 1, 1e-9);
  EXPECT_THAT(test::read_text(folder / "rec/imu.csv"), HasSubstr(",0.1,0.2,0.3,0,0,9.81,20,0,-44\n"));
  for (const auto& entry : fs::directory_iterator(folder / "rec")) EXPECT_NE(entry.path().filename(), ".reserve");
}

TEST(Recorder, AListedImageIsWholeAtEveryMoment) {
  const TempFolder folder;
  RecorderOptions options = options_for(folder / "rec");
  options.sync_interval = 0.02;
  Recorder recorder(options);
  std::set<std::string> checked;
  for (int i = 0; i < 100; ++i) {
    recorder.add(noisy_frame(i));
    for (const std::string& file : listed(folder / "rec", "depth.txt"))
      if (checked.insert(file).second) {
        ASSERT_NO_THROW(read_depth_image(file)) << file;
      }
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
  }
  EXPECT_GT(checked.size(), 5u);
}

TEST(Recorder, NeverOverwritesARecording) {
  const TempFolder folder;
  { Recorder recorder(options_for(folder / "rec")); }
  const std::string before = test::read_text(folder / "rec/depth.txt");
  EXPECT_THAT(test::error_of([&] { Recorder recorder(options_for(folder / "rec")); }), HasSubstr("holds a recording"));
  EXPECT_EQ(test::read_text(folder / "rec/depth.txt"), before);
}

TEST(Recorder, AFolderThatCannotBeMadeIsTold) {
  EXPECT_THAT(test::error_of([] { Recorder recorder(options_for("/proc/rec")); }), HasSubstr("/proc/rec"));
}

TEST(Recorder, FramesForWhichTheDiskIsTooSlowAreCountedDepthAndColourTogether) {
  const TempFolder folder;
  RecorderOptions options = options_for(folder / "rec");
  options.queue = 1;
  Recorder recorder(options);
  for (int i = 0; i < 200; ++i) recorder.add(noisy_frame(i));
  recorder.finish();
  const RecorderStatus status = recorder.status();
  EXPECT_GT(status.dropped, 0u);
  EXPECT_EQ(status.frames + status.dropped, 200u);
  EXPECT_EQ(listed(folder / "rec", "depth.txt").size(), status.frames);
  EXPECT_EQ(listed(folder / "rec", "rgb.txt").size(), status.frames);
}

TEST(Recorder, AFullDiskEndsTheRecordingAndKeepsWhatThereIs) {
  const TempFolder folder;
  const test::SmallDisk disk(folder / "disk", "size=4m");
  if (!disk.mounted()) GTEST_SKIP() << "no permission to mount a tmpfs";
  Recorder recorder(options_for(folder / "disk/rec"));
  std::string message;
  for (int i = 0; i < 5000 && message.empty(); ++i) {
    recorder.add(noisy_frame(i));
    recorder.add(reading_at(now()));
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    try {
      recorder.check();
    } catch (const Error& error) {
      message = error.what();
    }
  }
  EXPECT_THAT(message, HasSubstr("no space left"));
  EXPECT_THAT(test::error_of([&] { recorder.finish(); }), HasSubstr("no space left"));

  // Nearly everything that the disk took is there: an image is some 10 KB of the 4 MB.
  const std::vector<std::string> depth = listed(folder / "disk/rec", "depth.txt");
  EXPECT_GT(depth.size(), 100u);
  const auto sequence = open_sequence(folder / "disk/rec");
  EXPECT_EQ(static_cast<std::size_t>(sequence->size()), depth.size());
  for (int i = 0; i < sequence->size(); ++i) EXPECT_NO_THROW(sequence->read(i));
  EXPECT_GT(read_orientations(folder / "disk/rec/orientation.txt", {}).size(), 10u);
}

/// What a loss of power leaves: lists that end anywhere, or in zeros where the disk had no time to write.
TEST(Recorder, TheReadersTakeListsThatEndAnywhere) {
  const TempFolder folder;
  {
    Recorder recorder(options_for(folder / "rec"));
    for (int i = 0; i < 3; ++i) recorder.add(noisy_frame(i));
    for (int i = 0; i < 3; ++i) recorder.add(reading_at(now() + i * kFrame));
  }
  for (const char* name : {"depth.txt", "rgb.txt", "orientation.txt"}) {
    const std::string path = folder / (std::string("rec/") + name), whole = test::read_text(path);
    const std::size_t last_line = whole.rfind('\n', whole.size() - 2) + 1;
    for (std::size_t end = last_line; end < whole.size(); ++end) {
      for (const std::size_t zeros : {0, 1, 700}) {
        test::write_text(path, whole.substr(0, end) + std::string(zeros, '\0'));
        EXPECT_NO_THROW({
          const auto sequence = open_sequence(folder / "rec");
          EXPECT_GE(sequence->size(), 2);
          for (int i = 0; i < sequence->size(); ++i) sequence->read(i);
          EXPECT_GE(read_orientations(folder / "rec/orientation.txt", {}).size(), 2u);
        }) << name
           << " cut at " << end << " with " << zeros << " zeros";
      }
    }
    test::write_text(path, whole);
  }
}

}  // namespace
}  // namespace plumbline::capture
