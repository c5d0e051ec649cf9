// `orientation` and `characterise`: what a user types, the files that are left, and what is said of bad ones.
#include <gmock/gmock.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/sensor_model.h"
#include "plumbline/angles.h"
#include "plumbline/files.h"
#include "plumbline/se3.h"
#include "support/program.h"
#include "support/small_sequence.h"

namespace plumbline::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

class OrientationCommand : public SmallSequence {
 protected:
  /// Twelve seconds of a hand's motion: raw readings, and the orientations that they are of.
  void simulate() const {
    const Outcome made =
        plumbline({"simulate", "-o", path("sim"), "--scene", "corridor", "--trajectory", "dance", "--duration", "12",
                   "--size", "32x24", "--rate", "5", "--no-color", "--imu-ideal", "--quiet"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
  Outcome filter(const std::vector<std::string>& more) const {
    std::vector<std::string> words = {"orientation", path("sim/imu.csv"), "-o", path("o.txt")};
    words.insert(words.end(), more.begin(), more.end());
    return plumbline(words);
  }
};

TEST_F(OrientationCommand, ComesNearTheTruthAndTellsHowNear) {
  simulate();
  const Outcome outcome = filter({"--reference", path("sim/orientation.txt"), "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto told = nlohmann::json::parse(outcome.out);
  EXPECT_LT(told["rmse"]["inclination_deg"], 2);
  EXPECT_LT(told["rmse"]["total_deg"], 6);
  EXPECT_EQ(read_orientations(path("o.txt"), {}).size(), told["readings"]);
}

TEST_F(OrientationCommand, SaysThatAnAccelerometerKnowsNoHeading) {
  simulate();
  const Outcome outcome = filter({"--no-gyroscope"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("tilt only"));
  EXPECT_THAT(read_text(path("o.txt")), HasSubstr("tilt only"));
}

TEST_F(OrientationCommand, RefusesWhatDoesNotGoTogether) {
  simulate();
  EXPECT_THAT(filter({"--filter", "madgwick", "--offline"}).err, HasSubstr("backward pass"));
  EXPECT_THAT(filter({"--filter", "madgwick", "--no-gyroscope"}).err, HasSubstr("gyroscope"));
  EXPECT_FALSE(std::filesystem::exists(path("o.txt")));
  write_text(path("sim/imu.csv"), "no,such,columns\n1,2,3\n");
  const Outcome outcome = filter({});
  EXPECT_NE(outcome.exit_code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("imu.csv"));
}

/// Rests of 6 s every 10° of heading; the sensor is off by 8° · sin(heading), which depends on nothing else.
class CharacteriseCommand : public SmallSequence {
 protected:
  CharacteriseCommand() {
    std::string reference, readings;
    for (int i = 0; i < 36; ++i) {
      const double heading = (10 * i - 175) * kRadiansPerDegree,
                   seen = heading + 8 * kRadiansPerDegree * std::sin(heading);
      for (const int second : {0, 6}) reference += line(8 * i + second, heading);
      for (int k = 0; k < 60; ++k) readings += line(8 * i + 0.1 * k, seen);
    }
    write_text(path("reference.txt"), reference);
    write_text(path("readings.txt"), readings);
  }
  static std::string line(double time, double heading) {
    return std::to_string(time) + " 0 0 " + std::to_string(std::sin(heading / 2)) + " " +
           std::to_string(std::cos(heading / 2)) + "\n";
  }
  Outcome characterise(const std::vector<std::string>& more) const {
    std::vector<std::string> words = {"characterise", "--reference", path("reference.txt"), "--readings",
                                      path("readings.txt")};
    words.insert(words.end(), more.begin(), more.end());
    return plumbline(words);
  }
};

TEST_F(CharacteriseCommand, FindsTheErrorAndWritesTableAndModel) {
  const Outcome outcome = characterise({"-o", path("model.toml"), "--csv", path("table.csv")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("Z (up)     36 angles: systematic within ±"));
  EXPECT_THAT(read_text(path("table.csv")), StartsWith("axis,angle_deg,readings,systematic_deg"));
  const app::SensorModel model = app::read_sensor_model(path("model.toml"));
  EXPECT_NEAR(model.error.amplitude.z(), 8 * kRadiansPerDegree, 0.4 * kRadiansPerDegree);
  EXPECT_NEAR(std::sqrt(model.covariance(2, 2)), 8 * kRadiansPerDegree / std::sqrt(2), 0.1 * kRadiansPerDegree)
      << "rms over all angles";
}

TEST_F(CharacteriseCommand, RefusesReadingsOfAnotherTime) {
  write_text(path("readings.txt"), line(1e6, 0) + line(1e6 + 1, 0));
  const Outcome outcome = characterise({"-o", path("model.toml")});
  EXPECT_NE(outcome.exit_code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("no rest"));
  EXPECT_FALSE(std::filesystem::exists(path("model.toml")));
}

}  // namespace
}  // namespace plumbline::test
