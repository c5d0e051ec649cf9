// `calibrate` on the poses of a simulated dance, and the file that it leaves.
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "plumbline/angles.h"
#include "plumbline/calibration.h"
#include "plumbline/orientation_calibration.h"
#include "plumbline/se3.h"
#include "support/program.h"
#include "support/small_sequence.h"

namespace plumbline::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class Calibrate : public SmallSequence {
 protected:
  void simulate(const std::string& trajectory, const std::string& duration, const std::string& size = "32x24",
                const std::string& distortion = "0.4") const {
    const Outcome made = plumbline({"simulate",
                                    "-o",
                                    path("sim"),
                                    "--scene",
                                    "room",
                                    "--trajectory",
                                    trajectory,
                                    "--duration",
                                    duration,
                                    "--rate",
                                    "20",
                                    "--size",
                                    size,
                                    "--no-color",
                                    "--distortion",
                                    distortion,
                                    "--imu-mounting",
                                    "0.5 0.5 -0.5 0.5",
                                    "--imu-latency",
                                    "0.03",
                                    "--imu-clock-offset",
                                    "0.2",
                                    "--quiet",
                                    "--seed",
                                    "4"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
  Outcome calibrate(const std::vector<std::string>& more) const {
    std::vector<std::string> words = {"calibrate", "-o", path("m.toml")};
    words.insert(words.end(), more.begin(), more.end());
    return plumbline(words);
  }
  void expect_found(double degrees = 0.05, double seconds = 0.001) const {
    const OrientationCalibration found = read_orientation_calibration(path("m.toml"));
    const Eigen::Matrix3d truth = Eigen::Quaterniond(0.5, 0.5, 0.5, -0.5).toRotationMatrix();
    EXPECT_LT(so3::angle(found.body_from_camera.transpose() * truth), degrees * kRadiansPerDegree);
    EXPECT_NEAR(found.time_offset, -0.23, seconds);
  }
};

TEST_F(Calibrate, TakesPosesFromAFile) {
  simulate("dance", "9");
  const std::string readings = path("sim") + "/orientation.txt", truth = path("sim") + "/groundtruth.txt";
  const Outcome outcome = calibrate({"--trajectory", truth, "--orientation", readings});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("Tsai-Lenz"), HasSubstr("Park-Martin"), HasSubstr("rich enough")));
  expect_found();
  // The same poses taken for those of a target are another motion, and no mounting makes it fit.
  const Outcome other = calibrate({"--trajectory", truth, "--trajectory-of", "target", "--orientation", readings});
  EXPECT_EQ(other.exit_code, 1) << other.out;
}

/// The camera's path is the tracker's, and its depth is bent as a Kinect's is: without straightening it the tracked
/// turns err by a fifth and no mounting is found.
TEST_F(Calibrate, ARenderedRecordingIsCalibratedThroughTheTracker) {
  simulate("dance", "9", "160x120");
  const Outcome outcome =
      calibrate({path("sim"), "--orientation", path("sim") + "/orientation.txt", "--depth-output", path("depth.toml")});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("181 of 181 frames tracked"), HasSubstr("cm rms at 2 m")));
  expect_found(0.6, 0.003);
  const DepthDistortion depth = read_depth_calibration(path("depth.toml"));
  EXPECT_GT(depth.rms(), 0.005);
  EXPECT_LT(depth.rms(), 0.015);
  const Outcome straight = plumbline(small_run(
      path("sim"), path("out"), {"--depth-calibration", path("depth.toml"), "--max-frames", "3", "--no-mesh"}));
  EXPECT_EQ(straight.exit_code, 0) << straight.err;
  EXPECT_THAT(straight.out, HasSubstr("is taken out"));
  const Outcome other = plumbline(small_run(sequence(), path("other"), {"--depth-calibration", path("none.toml")}));
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_THAT(other.err, HasSubstr("none.toml"));
}

TEST_F(Calibrate, ARunStraightensTheDepthByItself) {
  simulate("dance", "9", "160x120");
  const auto rmse = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"run", path("sim"), "-o", path("out"), "--no-mesh", "--no-report"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = plumbline(words);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const auto summary = nlohmann::json::parse(read_text(path("out/summary.json")));
    EXPECT_EQ(summary["lost"], 0);
    EXPECT_EQ(summary["depth_calibration"].is_null(), !std::filesystem::exists(path("out/depth.toml")));
    return summary["ate"]["rmse_m"].get<double>();
  };
  const double straight = rmse({});
  EXPECT_GT(read_depth_calibration(path("out/depth.toml")).rms(), 0.005);
  const double bent = rmse({"--set", "preprocess.calibrate_depth=false"});
  EXPECT_FALSE(std::filesystem::exists(path("out/depth.toml"))) << "an older one tells of another run";
  EXPECT_LT(straight, 0.5 * bent);
  // Found once, it serves again, and is not looked for.
  ASSERT_EQ(plumbline({"calibrate", path("sim"), "--depth-output", path("depth.toml")}).exit_code, 0);
  EXPECT_LT(rmse({"--depth-calibration", path("depth.toml")}), 0.5 * bent);
  EXPECT_FALSE(std::filesystem::exists(path("out/depth.toml")));
}

TEST_F(Calibrate, ARunLeavesACameraAloneThatBendsNothing) {
  simulate("dance", "9", "160x120", "0");
  const Outcome outcome = plumbline({"run", path("sim"), "-o", path("out"), "--no-mesh", "--no-report"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_FALSE(std::filesystem::exists(path("out/depth.toml")));
  EXPECT_THAT(outcome.out, testing::Not(HasSubstr("is taken out")));
}

TEST_F(Calibrate, TheDepthAloneNeedsNoSensorButMotion) {
  const Outcome still = calibrate({sequence(), "--depth-output", path("depth.toml"), "--set", "volume.resolution=128"});
  EXPECT_EQ(still.exit_code, 1) << still.out;
  EXPECT_THAT(still.err, HasSubstr("could not be told"));
  EXPECT_FALSE(std::filesystem::exists(path("depth.toml")));
}

TEST_F(Calibrate, PoorMotionWritesNothingUnlessForced) {
  simulate("sweep", "6");
  const std::vector<std::string> words = {"--trajectory", path("sim") + "/groundtruth.txt", "--orientation",
                                          path("sim") + "/orientation.txt"};
  const Outcome outcome = calibrate(words);
  EXPECT_EQ(outcome.exit_code, 1) << outcome.out;
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("turn it in about ten seconds"), HasSubstr("--force")));
  EXPECT_FALSE(std::filesystem::exists(path("m.toml")));
  std::vector<std::string> forced = words;
  forced.emplace_back("--force");
  EXPECT_EQ(calibrate(forced).exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(path("m.toml")));
}

TEST_F(Calibrate, WrongWordsAreMistakes) {
  write_text(path("o.txt"), "1 0 0 0 1\n1.1 0 0 0 1\n");
  const Outcome nothing = calibrate({sequence()});
  EXPECT_EQ(nothing.exit_code, 2);
  EXPECT_THAT(nothing.err, HasSubstr("nothing to calibrate"));
  EXPECT_EQ(calibrate({"--depth-output", path("d.toml"), "--trajectory", path("o.txt")}).exit_code, 2);
  EXPECT_EQ(calibrate({"--orientation", path("o.txt")}).exit_code, 2);
  const Outcome given = calibrate({sequence(), "--orientation", path("o.txt"), "--mounting", "0 0 0 1"});
  EXPECT_EQ(given.exit_code, 2);
  EXPECT_THAT(given.err, HasSubstr("what is looked for"));
}

}  // namespace
}  // namespace plumbline::test
