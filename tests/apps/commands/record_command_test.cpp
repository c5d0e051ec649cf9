// `plumbline record` and `plumbline run live:` as a user has them: another process, devices that fail, kills.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <csignal>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <thread>

#include "capture/clock.h"
#include "cli/capture_arguments.h"
#include "io/images/image_file.h"
#include "io/trajectory.h"
#include "plumbline/files.h"
#include "plumbline/sequence.h"
#include "plumbline/time.h"
#include "support/fake_bno055.h"
#include "support/program.h"
#include "support/small_sequence.h"
#include "support/terminal.h"

namespace plumbline::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

void pause(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

double unix_seconds() { return to_seconds(capture::now() + capture::unix_offset()); }

class Record : public SmallSequence {
 protected:
  /// The ten views of the desk to and fro for a minute, 30 a second: a camera that goes on.
  std::string long_sequence() const {
    std::ofstream list(sequence() + "/depth.txt"), colors(sequence() + "/rgb.txt");
    const std::vector<std::string> images = depth_images();
    const int last = kSmallFrames - 1;
    for (int i = 0; i < 1800; ++i) {
      const int at = std::abs((i + last) % (2 * last) - last);
      const std::string name = fs::path(images[at]).filename().string();
      list << fmt::format("{:.6f} depth/{}\n", 100 + i / 30.0, name);
      colors << fmt::format("{:.6f} rgb/{}\n", 100 + i / 30.0, name);
    }
    return sequence();
  }

  std::vector<std::string> record(const std::string& folder, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"record", "--depth", "virtual:" + sequence(), "-o", folder};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  /// Waits until the recording in `folder` lists its first images, for at most 30 s.
  static void wait_for_frames(const std::string& folder, std::size_t lines = 3) {
    for (int i = 0; i < 3000; ++i) {
      const std::string list = read_text(folder + "/depth.txt");
      if (static_cast<std::size_t>(std::count(list.begin(), list.end(), '\n')) >= lines) return;
      pause(0.01);
    }
    ADD_FAILURE() << "no frame was recorded in " << folder;
  }

  Outcome run_on(const std::string& folder, std::vector<std::string> more = {}) const {
    more.insert(more.end(), {"--orientation", folder + "/orientation.txt", "--set", "volume.resolution=64",
                             "--max-frames", "30", "--no-mesh"});
    return plumbline(small_run(folder, path("result"), more));
  }
};

TEST_F(Record, ARecordingOfTheVirtualCameraIsTheSequenceItself) {
  const Outcome outcome = plumbline(record(path("rec"), {"--speed", "0"}));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("recorded   10 frames"));
  const auto original = open_sequence(sequence()), recorded = open_sequence(path("rec"));
  ASSERT_EQ(recorded->size(), original->size());
  EXPECT_EQ(recorded->info().camera, original->info().camera);
  for (int i = 0; i < original->size(); ++i) {
    EXPECT_EQ(recorded->read(i).depth.pixels, original->read(i).depth.pixels);
    EXPECT_EQ(recorded->read(i).color.pixels, original->read(i).color.pixels);
    EXPECT_NEAR(to_seconds(recorded->time(i) - recorded->time(0)), to_seconds(original->time(i) - original->time(0)),
                2e-6);
  }
}

TEST_F(Record, WithASensorUntilCtrlC) {
  PLUMBLINE_TERMINAL_OR_SKIP();
  FakeBno055 chip(folder_);
  chip.calibration_status = 0xFF;
  chip.overruns = 0.05;
  long_sequence();
  Running recording(record(path("rec"), {"--imu", chip.connection()}));
  wait_for_frames(path("rec"), 20);
  chip.set_calibration({1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22});
  kill(recording.pid(), SIGINT);
  const Outcome outcome = recording.wait();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out,
              AllOf(HasSubstr("BNO055 (firmware 3.11)"), HasSubstr("calibration sys 3 gyro 3 acc 3 mag 3")));
  EXPECT_GT(read_orientations(path("rec/orientation.txt"), {}).size(), 20u);
  EXPECT_THAT(read_text(path("rec/imu.csv")), HasSubstr("gyro_x"));
  EXPECT_THAT(read_text(path("rec/imu-calibration.txt")), HasSubstr("01 02 03 04 05 06 07 08 09 0a 0b"));
  EXPECT_EQ(run_on(path("rec")).exit_code, 0);

  // The next recording begins with what the chip knew.
  chip.brown_out();
  const Outcome next = plumbline(record(path("next"), {"--imu", chip.connection(), "--imu-calibration",
                                                       path("rec/imu-calibration.txt"), "--duration", "0.5"}));
  EXPECT_EQ(next.exit_code, 0) << next.err;
  EXPECT_EQ(read_text(path("next/imu-calibration.txt")), read_text(path("rec/imu-calibration.txt")));
}

TEST_F(Record, ASensorThatIsUnpluggedInMidStreamCostsNoFrames) {
  PLUMBLINE_TERMINAL_OR_SKIP();
  FakeBno055 chip(folder_);
  long_sequence();
  Running recording(record(path("rec"), {"--imu", chip.connection()}));
  wait_for_frames(path("rec"), 10);
  chip.unplug();
  wait_for_frames(path("rec"), 40);
  chip.plug_in();
  pause(1.5);
  kill(recording.pid(), SIGINT);
  const Outcome outcome = recording.wait();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("the port is gone"), HasSubstr("is back after")));
  EXPECT_THAT(outcome.out, HasSubstr("1 reconnections"));
}

/// PLUMBLINE_KILLS=20 in the environment kills as often as that.
TEST_F(Record, KilledAtAnyMomentItLosesASecondAtMost) {
  PLUMBLINE_TERMINAL_OR_SKIP();
  const char* const wanted = std::getenv("PLUMBLINE_KILLS");
  const int kills = wanted != nullptr ? std::atoi(wanted) : 3;
  // A second is for a machine of one's own; one that runs other tests beside it stalls for longer.
  const double limit = wanted != nullptr ? 1.0 : 5.0;
  FakeBno055 chip(folder_);
  long_sequence();
  std::mt19937 random(7);
  for (int i = 0; i < kills; ++i) {
    const std::string folder = path(fmt::format("rec{}", i));
    Running recording(record(folder, {"--imu", chip.connection(), "--quiet"}));
    wait_for_frames(folder);
    pause(std::uniform_real_distribution<>(0, 2)(random));
    const double killed = unix_seconds();
    kill(recording.pid(), SIGKILL);
    EXPECT_EQ(recording.wait().exit_code, 1000 + SIGKILL);

    const auto recorded = open_sequence(folder);
    for (int frame = 0; frame < recorded->size(); ++frame) EXPECT_NO_THROW(recorded->read(frame)) << folder;
    const auto orientations = read_orientations(folder + "/orientation.txt", {});
    const double lost = killed - to_seconds(recorded->info().last_time);
    const double lost_readings = killed - to_seconds(orientations.back().time);
    EXPECT_LT(lost, limit) << folder;
    EXPECT_LT(lost_readings, limit) << folder;
    const Outcome outcome = run_on(folder);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    if (wanted != nullptr)
      fmt::print("kill {}: {} frames, {} with colour, lost {:.2f} s of images, {:.3f} s of readings\n", i,
                 recorded->size(), recorded->info().color_frames, lost, lost_readings);
  }
}

TEST_F(Record, MistakesAreTold) {
  const auto expect = [&](const std::vector<std::string>& arguments, int code, const std::string& words) {
    const Outcome outcome = plumbline(arguments);
    EXPECT_EQ(outcome.exit_code, code) << outcome.err;
    EXPECT_THAT(outcome.err, AllOf(HasSubstr("plumbline: error: "), HasSubstr(words)));
  };
  expect({"record", "--depth", "none", "-o", path("rec")}, 2, "nothing to record");
  expect({"record", "--depth", "webcam", "-o", path("rec")}, 1, "openni2");
  expect(record(path("rec"), {"--imu", "serial:/dev/none"}), 1, "/dev/none");
  expect(record(path("rec"), {"--imu", "usb"}), 1, "serial:/dev/ttyUSB0");
  expect(record(path("rec"), {"--imu-calibration", path("none")}), 2, "--imu");
  expect(record(path("rec"), {"--speed", "2", "--imu", "serial:/dev/none"}), 2, "--speed");
  expect(record(sequence()), 1, "holds a recording already");
  expect({"run", sequence(), "--imu", "serial:/dev/none", "-o", output()}, 2, "live");
  expect({"run", "live:", "--depth", "virtual:/nowhere", "-o", output()}, 1, "/nowhere");
  EXPECT_FALSE(fs::exists(path("rec/depth.txt")));
}

TEST_F(Record, TheStatusLineNamesRateDropsAndCalibration) {
  PLUMBLINE_TERMINAL_OR_SKIP();
  FakeBno055 chip(folder_);
  chip.calibration_status = 0b11'10'01'00;
  long_sequence();
  const Outcome outcome = plumbline_on_terminal(record(path("rec"), {"--imu", chip.connection(), "--duration", "1.5"}));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("/s, "), HasSubstr("dropped"), HasSubstr("sys 3 gyro 2 acc 1 mag 0")));
}

#ifdef PLUMBLINE_FAKENECT
/// What fakenect plays: 10 images of each kind, colour 3 ms after depth, stamped by a clock of 60 MHz that runs over.
void write_fakenect_folder(const fs::path& folder) {
  fs::create_directories(folder);
  std::string index;
  for (unsigned i = 0; i < 10; ++i) {
    const unsigned ticks = 0xFFFFFFFFu - 9'000'000u + 2'000'000u * i;
    const std::string depth = fmt::format("d-{:.6f}-{}.pgm", 50 + i / 30.0, ticks);
    const std::string color = fmt::format("r-{:.6f}-{}.ppm", 50.003 + i / 30.0, ticks + 180'000u);
    const std::uint16_t reading = static_cast<std::uint16_t>(1000 + i);
    std::string pixels(640 * 480 * 2, '\0');
    for (std::size_t k = 0; k < pixels.size(); k += 2) std::memcpy(&pixels[k], &reading, 2);
    write_text((folder / depth).string(), "P5 640 480 65535\n" + pixels);
    write_text((folder / color).string(), "P6 640 480 255\n" + std::string(640 * 480 * 3, static_cast<char>(i)));
    index += depth + "\n" + color + "\n";
  }
  write_text((folder / "INDEX.txt").string(), index);
}

TEST_F(Record, AKinectWhoseImagesComeToAnEnd) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "the address sanitizer wants to be loaded before what this test preloads";
#endif
  if (!fs::exists(PLUMBLINE_FAKENECT)) GTEST_SKIP() << "libfreenect's fakenect is not installed";
  write_fakenect_folder(path("kinect"));
  Launch launch;
  const std::string played = path("kinect");
  launch.in_child = [&played] {
    setenv("LD_LIBRARY_PATH", PLUMBLINE_FAKENECT, 1);
    setenv("LD_PRELOAD", PLUMBLINE_FAKENECT_MODES, 1);
    setenv("FAKENECT_PATH", played.c_str(), 1);
  };
  const Outcome outcome = plumbline({"record", "--depth", "freenect", "-o", path("rec")}, launch);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("the Kinect does not answer any more"));
  const auto recorded = open_sequence(path("rec"));
  ASSERT_GE(recorded->size(), 9);  // the last one waits for its colour
  EXPECT_EQ(recorded->info().camera.fx, 525);
  EXPECT_GE(recorded->info().color_frames, 9);
  for (int i = 0; i < recorded->size(); ++i) EXPECT_EQ(recorded->read(i).depth.at(5, 5), 5 * (1000 + i));
  EXPECT_EQ(recorded->read(3).color.at(5, 5), 3);
  EXPECT_LT(to_seconds(recorded->info().last_time - recorded->info().first_time), 20);  // the overrun is no jump
}
#endif

TEST(SilenceWatch, TellsOnceWhenACameraFallsSilentAndOnceWhenItIsBack) {
  app::SilenceWatch watch;
  capture::GrabberStatus status;
  const auto silent_for = [&](double seconds) {
    status.silence = seconds;
    return watch.observe(status).value_or("");
  };
  EXPECT_EQ(silent_for(0.1), "");
  EXPECT_EQ(silent_for(1.9), "");
  EXPECT_THAT(silent_for(2.1), HasSubstr("no frame for 2 s"));
  EXPECT_EQ(silent_for(7.5), "");
  EXPECT_THAT(silent_for(0.0), HasSubstr("again, after 7.5 s"));
  EXPECT_EQ(silent_for(0.1), "");
}

// ---- Live ----

TEST_F(Record, LiveWithoutHurryIsARunOverTheSameFrames) {
  const std::vector<std::string> live = {"--depth", "virtual:" + sequence(), "--speed", "0"};
  const Outcome outcome = plumbline(small_run("live:", path("live"), live));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("10 frames, 0 of them dropped"));
  EXPECT_EQ(plumbline(small_run(sequence(), path("files"), {"--detail", "off"})).exit_code, 0);
  EXPECT_EQ(read_text(path("live/mesh.ply")), read_text(path("files/mesh.ply")));
}

TEST_F(Record, LiveTakesTheLatestFrameAndCountsTheOthers) {
  PLUMBLINE_TERMINAL_OR_SKIP();
  FakeBno055 chip(folder_);
  long_sequence();
  // A volume that takes its time.
  std::vector<std::string> arguments = small_run(
      "live:", output(),
      {"--depth", "virtual:" + sequence(), "--speed", "1", "--imu", chip.connection(), "--mounting", "0 0 0 1"});
  arguments.insert(arguments.end(), {"--set", "volume.resolution=256", "--threads", "1"});
  Running live(arguments);
  pause(3);
  kill(live.pid(), SIGINT);
  const Outcome outcome = live.wait();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto summary = nlohmann::json::parse(read_text(output() + "/summary.json"));
  const int frames = summary["frames"], captured = summary["live"]["captured"], dropped = summary["live"]["dropped"];
  EXPECT_GT(frames, 2);
  // Every frame was worked on, dropped, or waiting when the end came.
  EXPECT_LE(frames, captured);
  EXPECT_GE(dropped + 2, captured - frames);
  EXPECT_TRUE(fs::exists(output() + "/mesh.ply"));
  const auto& orientation = summary["orientation"];
  EXPECT_GT(orientation["used"].get<int>() + orientation["distrusted"].get<int>() + orientation["dropped"].get<int>(),
            0);
}

}  // namespace
}  // namespace plumbline::test
