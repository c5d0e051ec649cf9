#include <gmock/gmock.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "cli/arguments.h"
#include "cli/orientation_arguments.h"
#include "plumbline/angles.h"
#include "plumbline/orientation_calibration.h"
#include "plumbline/se3.h"
#include "support/error_of.h"
#include "support/temp_folder.h"

namespace plumbline::app {
namespace {

using Eigen::Vector3d;
using test::error_of;
using test::TempFolder;
using test::write_text;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

/// The stream of a command line, which CLI11 takes from its end.
std::optional<OrientationStream> load(std::vector<std::string> words, std::vector<std::string>* notes = nullptr) {
  CLI::App command;
  OrientationArguments arguments;
  add_orientation_arguments(command, arguments);
  std::reverse(words.begin(), words.end());
  command.parse(words);
  SensorReadings readings = load_orientation(arguments);
  if (notes != nullptr) *notes = readings.notes;
  return std::move(readings.orientation);
}

class OrientationOptions : public testing::Test {
 protected:
  void SetUp() override { write_text(file_, "1 0.6 0 0 0.8\n1.05 0.6 0 0 0.8\n1.25 0.6 0 0 0.8\n"); }
  TempFolder folder_;
  std::string file_ = folder_ / "o.txt";
  Eigen::Matrix3d turn_ = so3::exp(Vector3d(2 * std::atan2(0.6, 0.8), 0, 0));
};

TEST_F(OrientationOptions, WithoutThemThereIsNoStream) { EXPECT_FALSE(load({}).has_value()); }

TEST_F(OrientationOptions, ReachTheStream) {
  const auto plain = load({"--orientation", file_});
  ASSERT_TRUE(plain.has_value());
  EXPECT_TRUE(plain->lookup(1'020'000'000).earth_from_camera.isApprox(turn_, 1e-9));
  EXPECT_EQ(plain->lookup(1'150'000'000).status, OrientationStatus::gap);
  EXPECT_EQ(plain->options().convention.quaternion, QuaternionOrder::xyzw);

  const auto all =
      load({"--orientation", file_, "--quaternion", "xyzw", "--orientation-of", "world-to-body", "--earth", "ned",
            "--orientation-offset", "-0.5", "--mounting", "-0.5 0.5 0.5 0.5", "--orientation-max-gap", "0.3"});
  ASSERT_TRUE(all.has_value());
  const OrientationReading reading = all->lookup(650'000'000);
  ASSERT_EQ(reading.status, OrientationStatus::ok);
  const Eigen::Matrix3d mounting = Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5).toRotationMatrix();
  EXPECT_TRUE(reading.earth_from_camera.isApprox(enu_from(EarthAxes::ned) * turn_.transpose() * mounting, 1e-9));
}

TEST_F(OrientationOptions, AddTheErrorModel) {
  std::vector<std::string> notes;
  const auto bno = load({"--orientation", file_, "--imu-model", "bno055", "--imu-seed", "4"}, &notes);
  EXPECT_THAT(notes, ElementsAre(HasSubstr("3°, 3° (tilt) and 10° (heading) was added, seed 4")));
  const auto same = load({"--orientation", file_, "--imu-model", "3,3,10", "--imu-seed", "4"});
  const auto other = load({"--orientation", file_, "--imu-model", "3,3,10", "--imu-seed", "5"});
  const auto ideal = load({"--orientation", file_, "--imu-model", "ideal"});
  const auto first = [](const auto& stream) { return stream->samples().front().earth_from_body; };
  EXPECT_EQ(first(bno), first(same));
  EXPECT_NE(first(bno), first(other));
  EXPECT_TRUE(first(ideal).isApprox(turn_, 1e-12));
  const double error = so3::angle(first(bno).transpose() * turn_);
  EXPECT_GT(error, 0.01 * kRadiansPerDegree);
  EXPECT_LT(error, 11 * kRadiansPerDegree);
}

TEST_F(OrientationOptions, ComeFromACalibration) {
  OrientationCalibration written;
  written.body_from_camera = Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5).toRotationMatrix();
  written.mounting_sd = Vector3d(0.1, 0.2, 0.3) * kRadiansPerDegree;
  written.time_offset = -0.5;
  written.time_offset_sd = 0.001;
  written.convention = {QuaternionOrder::xyzw, OrientationOf::world_to_body, EarthAxes::ned};
  const std::string file = folder_ / "m.toml";
  write_orientation_calibration(file, written, {"a comment"});
  const auto read = read_orientation_calibration(file);
  EXPECT_TRUE(read.mounting_sd.isApprox(written.mounting_sd, 1e-3));
  EXPECT_EQ(read.time_offset_sd, 0.001);

  const auto stream = load({"--orientation", file_, "--orientation-calibration", file});
  EXPECT_TRUE(stream->options().body_from_camera.isApprox(written.body_from_camera, 1e-8));
  EXPECT_EQ(stream->options().time_offset, -0.5);
  EXPECT_TRUE(stream->samples().front().earth_from_body.isApprox(enu_from(EarthAxes::ned) * turn_.transpose(), 1e-9));
  const auto other = load({"--orientation", file_, "--orientation-calibration", file, "--orientation-offset", "0",
                           "--earth", "enu", "--mounting", "0 0 0 1"});
  EXPECT_EQ(other->options().time_offset, 0);
  EXPECT_TRUE(other->options().body_from_camera.isIdentity());
  EXPECT_TRUE(other->samples().front().earth_from_body.isApprox(turn_.transpose(), 1e-9));
}

TEST_F(OrientationOptions, ABadCalibrationIsToldWithItsLine) {
  const std::string file = folder_ / "m.toml";
  const auto error = [&](const std::string& text) {
    write_text(file, text);
    return error_of([&] { read_orientation_calibration(file); });
  };
  const std::string mounting = "[mounting]\nbody_from_camera = [0, 0, 0, 1]\nsd_deg = [1, 1, 1]\n",
                    time = "[time]\noffset = 0.1\nsd = 0.001\n";
  EXPECT_THAT(error("[mounting\n"), HasSubstr("m.toml:1"));
  EXPECT_THAT(error("[mounting]\n"), HasSubstr("there is no mounting.body_from_camera"));
  EXPECT_THAT(error("[mounting]\nbody_from_camera = [0, 0, 1]\n"), HasSubstr("m.toml:2"));
  EXPECT_THAT(error("[mounting]\nbody_from_camera = [0, 0, 0.5, 0.5]\n"), HasSubstr("no unit quaternion"));
  EXPECT_THAT(error(mounting), HasSubstr("there is no time.offset"));
  EXPECT_THAT(error(mounting + "[time]\noffset = \"soon\"\n"), HasSubstr("m.toml:5"));
  EXPECT_THAT(error(mounting + "[time]\noffset = nan\n"), HasSubstr("not a number in range"));
  EXPECT_THAT(error(mounting + time + "[readings]\nquaternion = \"wyxz\"\n"), HasSubstr("m.toml:8"));
  EXPECT_THAT(error_of([&] { read_orientation_calibration(folder_ / "none.toml"); }), HasSubstr("none.toml"));
}

TEST_F(OrientationOptions, AloneAreMistakes) {
  for (const char* option : {"--quaternion=xyzw", "--orientation-of=world-to-body", "--earth=ned",
                             "--orientation-offset=1", "--orientation-calibration=m.toml", "--sensor-model=s.toml",
                             "--mounting=0 0 0 1", "--orientation-max-gap=1", "--imu-model=ideal"}) {
    try {
      load({option});
      ADD_FAILURE() << option;
    } catch (const CLI::ParseError& error) {
      EXPECT_THAT(error.what(), HasSubstr("requires --orientation")) << option;
    }
  }
  EXPECT_THROW(load({"--orientation", file_, "--imu-seed", "3"}), CLI::ParseError);
}

TEST_F(OrientationOptions, WithBadValuesAreMistakes) {
  const auto mistake = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"--orientation", file_});
    return error_of([&] {
      try {
        load(words);
      } catch (const UsageError&) {
        throw;
      } catch (const Error& error) {
        ADD_FAILURE() << "no mistake on the command line: " << error.what();
      }
    });
  };
  EXPECT_THAT(mistake({"--quaternion", "xywz"}), AllOf(HasSubstr("--quaternion"), HasSubstr("xyzw, wxyz")));
  EXPECT_THAT(mistake({"--orientation-of", "camera"}), HasSubstr("body-to-world, world-to-body"));
  EXPECT_THAT(mistake({"--earth", "nwu"}), HasSubstr("enu, ned, y-up"));
  EXPECT_THAT(mistake({"--mounting", "0 0 1"}), AllOf(HasSubstr("takes 4 numbers"), HasSubstr("QX QY QZ QW")));
  EXPECT_THAT(mistake({"--mounting", "0 0 1 1"}), HasSubstr("unit length"));
  EXPECT_THAT(mistake({"--imu-model", "mpu6050"}), HasSubstr("ideal, bno055"));
  EXPECT_THAT(mistake({"--imu-model", "3,3"}), HasSubstr("takes 3 numbers"));
  EXPECT_THAT(mistake({"--imu-model", "3,-3,10"}), HasSubstr("out of range"));
  EXPECT_THROW(load({"--orientation", file_, "--orientation-max-gap", "0"}), CLI::ParseError);
  EXPECT_THROW(load({"--orientation", file_, "--orientation-offset", "soon"}), CLI::ParseError);
}

TEST_F(OrientationOptions, NameAFileThatExists) {
  const std::string missing = folder_ / "none.txt";
  EXPECT_THROW(load({"--orientation", missing}), UsageError);
  EXPECT_THAT(error_of([&] { load({"--orientation", missing}); }), HasSubstr("there is no such file"));
  EXPECT_THAT(error_of([&] { load({"--orientation", folder_.path().string()}); }), HasSubstr("is a folder"));
}

}  // namespace
}  // namespace plumbline::app
