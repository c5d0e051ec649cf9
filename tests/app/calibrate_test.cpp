// `calibrate` on the poses of a simulated dance, and the file that it leaves.
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>

#include "app/program.h"
#include "app/small_sequence.h"
#include "core/se3.h"
#include "io/orientation_calibration.h"

namespace plumbline::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr double kDegree = 3.14159265358979 / 180;

class Calibrate : public SmallSequence {
 protected:
  void simulate(const std::string& trajectory, const std::string& duration) const {
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
                                    "32x24",
                                    "--no-color",
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
  void expect_found() const {
    const OrientationCalibration found = read_orientation_calibration(path("m.toml"));
    const Eigen::Matrix3d truth = Eigen::Quaterniond(0.5, 0.5, 0.5, -0.5).toRotationMatrix();
    EXPECT_LT(so3::angle(found.body_from_camera.transpose() * truth), 0.05 * kDegree);
    EXPECT_NEAR(found.time_offset, -0.23, 0.001);
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
  EXPECT_EQ(calibrate({sequence()}).exit_code, 2);
  EXPECT_EQ(calibrate({"--orientation", path("o.txt")}).exit_code, 2);
  const Outcome given = calibrate({sequence(), "--orientation", path("o.txt"), "--mounting", "0 0 0 1"});
  EXPECT_EQ(given.exit_code, 2);
  EXPECT_THAT(given.err, HasSubstr("what is looked for"));
}

}  // namespace
}  // namespace plumbline::test
