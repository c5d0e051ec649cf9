// `angles`: which pairs are chosen, and the test on a simulated sequence of turns.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "eval/turned_pairs.h"
#include "plumbline/angles.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"
#include "support/program.h"
#include "support/small_sequence.h"

namespace plumbline::test {
namespace {

using eval::TurnedPair;
using eval::TurnedPairOptions;
using testing::HasSubstr;

using Poses = std::vector<std::optional<SE3>>;

SE3 looking(double degrees, double x = 0) {
  return {so3::exp(Eigen::Vector3d(0, kRadiansPerDegree * degrees, 0)), Eigen::Vector3d(x, 0, 0)};
}

/// Turns by a degree a frame and drifts by a millimetre.
Poses steady_turn(int frames) {
  Poses poses;
  for (int i = 0; i < frames; ++i) poses.emplace_back(looking(i, 0.001 * i));
  return poses;
}

TurnedPairOptions at(double degrees, std::size_t count = 20) {
  TurnedPairOptions options;
  options.angle = kRadiansPerDegree * degrees;
  options.tolerance = kRadiansPerDegree * 0.5;
  options.count = count;
  return options;
}

TEST(TurnedPairs, HaveTheAngleAndLieSpreadOverTheSequence) {
  const Poses poses = steady_turn(300);
  const std::vector<TurnedPair> pairs = eval::turned_pairs(poses, at(15, 10));
  ASSERT_EQ(pairs.size(), 10U);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    EXPECT_NEAR(pairs[k].angle, kRadiansPerDegree * 15, 1e-9);
    EXPECT_NEAR(pairs[k].translation, 0.015, 1e-9);
    EXPECT_EQ(pairs[k].second, pairs[k].first + 15);
  }
  // All are equally good, so each stretch of 30 frames gives one; the last has no pair from its middle on.
  for (std::size_t k = 0; k < 9; ++k) EXPECT_EQ(pairs[k].first / 30, k);
}

TEST(TurnedPairs, AreTheSameEachTime) {
  const Poses poses = steady_turn(100);
  const auto first = eval::turned_pairs(poses, at(7)), second = eval::turned_pairs(poses, at(7));
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t k = 0; k < first.size(); ++k) {
    EXPECT_EQ(first[k].first, second[k].first);
    EXPECT_EQ(first[k].second, second[k].second);
  }
}

TEST(TurnedPairs, PreferTheSamePlace) {
  // As `simulate --turn` makes them: two frames at each place. Between places the camera turns by 20° as well.
  Poses poses;
  for (int place = 0; place < 10; ++place) {
    poses.emplace_back(looking(40 * place, 0.1 * place));
    poses.emplace_back(looking(40 * place + 20, 0.1 * place));
  }
  const std::vector<TurnedPair> pairs = eval::turned_pairs(poses, at(20, 10));
  ASSERT_EQ(pairs.size(), 10U);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    EXPECT_EQ(pairs[k].first, 2 * k);
    EXPECT_EQ(pairs[k].second, 2 * k + 1);
    EXPECT_EQ(pairs[k].translation, 0);
  }
}

TEST(TurnedPairs, AreAsManyAsThereAre) {
  const Poses poses = steady_turn(30);
  EXPECT_EQ(eval::turned_pairs(poses, at(25)).size(), 5U);
  EXPECT_TRUE(eval::turned_pairs(poses, at(60)).empty());
  EXPECT_TRUE(eval::turned_pairs({}, at(5)).empty());
  TurnedPairOptions near = at(25);
  near.max_translation = 0.02;
  EXPECT_TRUE(eval::turned_pairs(poses, near).empty()) << "25 mm apart";
}

TEST(TurnedPairs, ManyFromOneStretchWhereTheOthersHaveNone) {
  // The camera stands still for the first three quarters.
  Poses poses(300, looking(0));
  for (int i = 0; i < 100; ++i) poses.emplace_back(looking(i));
  const std::vector<TurnedPair> pairs = eval::turned_pairs(poses, at(50, 20));
  ASSERT_EQ(pairs.size(), 20U);
  std::set<std::size_t> first;
  for (const TurnedPair& pair : pairs) first.insert(pair.first);
  EXPECT_EQ(first.size(), pairs.size());
}

TEST(TurnedPairs, PassOverFramesWithoutAPose) {
  Poses poses = steady_turn(40);
  for (std::size_t i = 0; i < 40; i += 2) poses[i].reset();
  const std::vector<TurnedPair> pairs = eval::turned_pairs(poses, at(10));
  EXPECT_EQ(pairs.size(), 15U);
  for (const TurnedPair& pair : pairs) EXPECT_EQ(pair.first % 2 + pair.second % 2, 2U);
}

TEST(PoseAt, LiesBetweenItsNeighbours) {
  const Trajectory truth = {{0, looking(0, 0)}, {50'000'000, looking(10, 1)}, {500'000'000, looking(20, 2)}};
  EXPECT_NEAR(so3::angle(eval::pose_at(truth, 25'000'000)->rotation()), kRadiansPerDegree * 5, 1e-12);
  EXPECT_NEAR(eval::pose_at(truth, 10'000'000)->translation().x(), 0.2, 1e-12);
  EXPECT_EQ(eval::pose_at(truth, 50'000'400)->translation().x(), 1) << "a rounded stamp";
  EXPECT_EQ(eval::pose_at(truth, 499'999'600)->translation().x(), 2);
  for (const Nanoseconds outside : {-1'000'000LL, 200'000'000LL, 501'000'000LL})
    EXPECT_FALSE(eval::pose_at(truth, outside)) << outside;
}

class Angles : public SmallSequence {
 protected:
  Outcome simulate_turns(const std::string& degrees) const {
    return plumbline({"simulate", "-o", path("turn"), "--size", "160x120", "--frames", "8", "--speed", "6", "--scene",
                      "room", "--trajectory", "handheld", "--turn", degrees, "--exact", "--no-color", "--quiet"});
  }
  /// A coarse volume that holds the room.
  Outcome angles(const std::vector<std::string>& more) const {
    std::vector<std::string> words = {
        "angles", path("turn"),         "--set", "volume.resolution=192", "--set", "volume.side=8",
        "--set",  "volume.offset=-0.5", "--set", "volume.truncation=0.12"};
    words.insert(words.end(), more.begin(), more.end());
    return plumbline(words);
  }
};

TEST_F(Angles, FiveDegreesSucceedEverywhere) {
  ASSERT_EQ(simulate_turns("5").exit_code, 0);
  const Outcome outcome =
      angles({"--angles", "5,170", "--pairs", "4", "--orientation", path("turn") + "/groundtruth.txt", "--json",
              path("angles.json"), "--csv", path("angles.csv")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("fewer than 4 pairs for 1 of the 2 angles"));
  EXPECT_THAT(outcome.out, HasSubstr("with IMU       0    0   10"));
  const auto json = nlohmann::json::parse(read_text(path("angles.json")));
  ASSERT_EQ(json["angles"].size(), 2U);
  const auto& five = json["angles"][0];
  EXPECT_EQ(five["angle_deg"], 5);
  EXPECT_EQ(five["pairs"], 4);
  EXPECT_EQ(five["failures"], 0);
  EXPECT_EQ(five["lost"], 0);
  EXPECT_EQ(five["failure_percent"], 0);
  EXPECT_EQ(five["without_reading"], 0);
  EXPECT_GT(five["median_translation_error_m"], 0);
  EXPECT_LT(five["median_translation_error_m"], 0.01);
  EXPECT_EQ(json["angles"][1]["pairs"], 0);
  EXPECT_TRUE(json["angles"][1]["failure_percent"].is_null());
  const std::string csv = read_text(path("angles.csv"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 4);
  EXPECT_THAT(csv, HasSubstr("\n5,2,3,5.0000,0.000000,tracked,,used,"));

  // The same with a limit that nothing keeps, on any number of threads.
  for (const std::string threads : {"1", "2"}) {
    const Outcome strict = angles({"--angles", "5", "--pairs", "4", "--success-translation", "1e-6", "--threads",
                                   threads, "--json", path("strict" + threads)});
    ASSERT_EQ(strict.exit_code, 0) << strict.err;
    const auto failed = nlohmann::json::parse(read_text(path("strict" + threads)))["angles"][0];
    EXPECT_EQ(failed["failures"], 4);
    EXPECT_EQ(failed["failure_percent"], 100);
    EXPECT_EQ(failed["lost"], 0);
    EXPECT_TRUE(failed["median_rotation_error_deg"].is_null());
  }
}

// After a turn of 40° the error model's heading is off by more than ICP converges from.
TEST_F(Angles, SeveralStartsFindWhatOneDoesNot) {
  const Outcome simulated =
      plumbline({"simulate", "-o",          path("turn"), "--size",  "160x120",      "--frames", "16",
                 "--speed",  "6",           "--scene",    "room",    "--trajectory", "handheld", "--turn",
                 "40",       "--turn-axis", "pan",        "--exact", "--no-color",   "--quiet"});
  ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
  const auto failures = [&](const std::string& search) {
    int sum = 0;
    for (const char* seed : {"1", "2", "3"}) {
      const Outcome outcome = angles({"--angles", "40", "--pairs", "8", "--orientation",
                                      path("turn") + "/groundtruth.txt", "--imu-model", "bno055", "--imu-seed", seed,
                                      "--set", "orientation.search=" + search, "--json", path("starts.json")});
      EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
      sum += nlohmann::json::parse(read_text(path("starts.json")))["angles"][0]["failures"].get<int>();
    }
    return sum;  // of 24
  };
  const int with = failures("4"), without = failures("0");
  EXPECT_LE(with, 4);
  EXPECT_GE(without, with + 3);
}

TEST_F(Angles, BadInput) {
  std::filesystem::remove(sequence() + "/groundtruth.txt");
  const Outcome without = plumbline({"angles", sequence()});
  EXPECT_EQ(without.exit_code, 1);
  EXPECT_THAT(without.err, HasSubstr("there is no ground truth"));
  EXPECT_THAT(without.err, HasSubstr("--groundtruth"));
  write_text(path("other.txt"), "5 0 0 0 0 0 0 1\n");
  const Outcome elsewhere = plumbline({"angles", sequence(), "--groundtruth", path("other.txt")});
  EXPECT_EQ(elsewhere.exit_code, 1);
  EXPECT_THAT(elsewhere.err, HasSubstr("no frame has a pose at its time"));
  EXPECT_EQ(plumbline({"angles", sequence(), "--angles", "5,200"}).exit_code, 2);
  EXPECT_EQ(plumbline({"angles", sequence(), "--angles", "0"}).exit_code, 2);
  EXPECT_EQ(plumbline({"angles", sequence(), "--pairs", "0"}).exit_code, 2);
  EXPECT_EQ(plumbline({"angles", sequence(), "--imu-seed", "2"}).exit_code, 2);
  EXPECT_EQ(plumbline({"angles"}).exit_code, 2);
  EXPECT_EQ(plumbline({"angles", path("nowhere")}).exit_code, 1);
}

}  // namespace
}  // namespace plumbline::test
