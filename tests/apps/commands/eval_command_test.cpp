// `eval ate`, `eval rpe` and `plot` as a user starts them; above all what they say about bad files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "io/csv.h"
#include "io/trajectory.h"
#include "plumbline/frame.h"
#include "plumbline/se3.h"
#include "plumbline/trajectory.h"
#include "support/program.h"

namespace plumbline::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// A folder with a true trajectory of 100 poses, 30 a second, and estimates that differ from it by little waves.
class Evaluation : public testing::Test {
 protected:
  Evaluation() {
    write_tum_trajectory(truth(), way(0));
    fs::create_directories(path("a"));
    fs::create_directories(path("b"));
    write_tum_trajectory(path("a/trajectory.txt"), way(0.01));
    write_tum_trajectory(path("b/trajectory.txt"), way(0.02));
  }

  std::string path(const std::string& name) const { return (fs::path(folder_) / name).string(); }
  std::string truth() const { return path("truth.txt"); }

  static Trajectory way(double wave, double later = 0) {
    Trajectory trajectory;
    for (int i = 0; i < 100; ++i) {
      const double s = i / 30.0;
      const Eigen::Vector3d position(std::sin(s), 0.5 * std::cos(1.3 * s) + wave * std::sin(20 * s), 0.2 * s);
      trajectory.push_back({from_seconds(1000 + s + later), SE3(so3::exp({0.1 * s, 0, 0.2}), position)});
    }
    return trajectory;
  }

  Outcome ate(const std::vector<std::string>& arguments) const { return eval("ate", arguments); }
  Outcome eval(const std::string& error, const std::vector<std::string>& arguments) const {
    std::vector<std::string> words = {"eval", error, truth()};
    words.insert(words.end(), arguments.begin(), arguments.end());
    return plumbline(words);
  }

  /// The error of `eval ate` over a file with this text as the estimate.
  std::string error_over(const std::string& text) const {
    write_text(path("bad.txt"), text);
    const Outcome outcome = ate({path("bad.txt")});
    EXPECT_EQ(outcome.exit_code, 1) << outcome.out;
    EXPECT_THAT(outcome.err, AllOf(HasSubstr("plumbline: error: "), HasSubstr("\n  ")));
    EXPECT_EQ(outcome.out, "");
    return outcome.err;
  }

  /// The good estimate's text, for spoiling.
  std::string good_text() const { return read_text(path("a/trajectory.txt")); }

  test::TempFolder temp_;
  std::string folder_ = temp_.path().string();
};

// ---- what it gives

TEST_F(Evaluation, SeveralEstimatesAreRowsOfOneTable) {
  const Outcome outcome = ate({path("a/trajectory.txt"), path("b/trajectory.txt"), "--csv", path("table.csv"), "--json",
                               path("table.json"), "--plot", path("plot.svg")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("rmse"), HasSubstr("\na "), HasSubstr("\nb ")));
  const json rows = json::parse(read_text(path("table.json")))["estimates"];
  ASSERT_EQ(rows.size(), 2u);
  const double a = rows[0]["translation_m"]["rmse"], b = rows[1]["translation_m"]["rmse"];
  EXPECT_EQ(rows[0]["pairs"], 100);
  EXPECT_NEAR(a, 0.01 / std::sqrt(2), 1e-3);
  EXPECT_NEAR(b / a, 2, 1e-2);
  const CsvTable table = read_csv(path("table.csv"));
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(table.rows[1][table.column("estimate")], path("b/trajectory.txt"));
  EXPECT_NEAR(std::stod(table.rows[1][table.column("translation_rmse_m")]), b, 1e-9);
  EXPECT_THAT(read_text(path("plot.svg")), AllOf(HasSubstr(">truth<"), HasSubstr(">a<"), HasSubstr(">b<")));
}

TEST_F(Evaluation, RelativeErrorHasTwoTablesAndADelta) {
  const Outcome outcome =
      eval("rpe", {path("a/trajectory.txt"), path("b/trajectory.txt"), "--delta", "5", "--unit", "frames", "--json",
                   path("table.json"), "--csv", path("table.csv"), "--plot", path("plot.png"), "--keep-script"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out,
              AllOf(HasSubstr("a distance of 5 frames"), HasSubstr("translation (m)"), HasSubstr("rotation (deg)")));
  const json table = json::parse(read_text(path("table.json")));
  EXPECT_EQ(table["delta"]["unit"], "frames");
  EXPECT_EQ(table["estimates"][0]["pairs"], 94);
  EXPECT_EQ(read_csv(path("table.csv")).columns.size(), 2u + 12u);
  EXPECT_TRUE(fs::exists(path("plot.png")) && fs::exists(path("plot.gp")));
}

TEST_F(Evaluation, JsonOnStandardOutputStandsAlone) {
  for (const std::vector<std::string>& flag : {std::vector<std::string>{"--json"}, {"--json", "-"}}) {
    std::vector<std::string> words = {path("a/trajectory.txt")};
    words.insert(words.end(), flag.begin(), flag.end());
    const Outcome outcome = ate(words);
    EXPECT_EQ(json::parse(outcome.out)["estimates"].size(), 1u) << outcome.out;
  }
}

TEST_F(Evaluation, TheBestTimeOffsetIsToldAndNotApplied) {
  write_tum_trajectory(path("late.txt"), way(0, 0.012));
  const Outcome plain = ate({path("late.txt"), "--json"});
  const Outcome asked = ate({path("late.txt"), "--find-offset", "--json"});
  ASSERT_EQ(asked.exit_code, 0) << asked.err;
  const json row = json::parse(asked.out)["estimates"][0];
  EXPECT_NEAR(row["best_offset"]["offset_s"].get<double>(), -0.012, 1e-3);
  EXPECT_LT(row["best_offset"]["rmse_m"].get<double>(), 0.2 * row["best_offset"]["rmse_as_given_m"].get<double>());
  EXPECT_EQ(row["translation_m"], json::parse(plain.out)["estimates"][0]["translation_m"]);
  EXPECT_THAT(ate({path("late.txt"), "--find-offset"}).out, AllOf(HasSubstr("-0.01"), HasSubstr("not applied")));
}

TEST_F(Evaluation, ASingleCamerasPathIsScaledWhereThatIsWanted) {
  Trajectory small = way(0.01);
  for (StampedPose& pose : small)
    pose.world_from_camera = SE3(pose.world_from_camera.rotation(), 0.25 * pose.world_from_camera.translation());
  write_tum_trajectory(path("small.txt"), small);
  const Outcome hint = ate({path("small.txt")});
  EXPECT_THAT(hint.err, AllOf(HasSubstr("times as large"), HasSubstr("--scale")));
  const Outcome scaled = ate({path("small.txt"), "--scale", "--json"});
  ASSERT_EQ(scaled.exit_code, 0) << scaled.err;
  const json entry = json::parse(scaled.out)["estimates"][0];
  EXPECT_NEAR(entry["scale"].get<double>(), 4, 0.01);
  EXPECT_LT(entry["translation_m"]["rmse"].get<double>(), 0.011);
  EXPECT_THAT(ate({path("a/trajectory.txt")}).err, Not(HasSubstr("--scale")));
}

TEST_F(Evaluation, OneBadEstimateIsNamedAndTheOthersGoOn) {
  write_text(path("bad.txt"), "1 2 3\n1 2 3\n");
  const Outcome outcome = ate({path("a/trajectory.txt"), path("bad.txt"), path("none.txt"), "--json", path("t.json")});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.out, HasSubstr("100"));
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("bad.txt:1: has 3 fields"), HasSubstr("none.txt: cannot be read")));
  const json rows = json::parse(read_text(path("t.json")))["estimates"];
  EXPECT_TRUE(rows[0].contains("pairs"));
  EXPECT_THAT(rows[1]["problem"].get<std::string>(), HasSubstr("bad.txt:1"));
}

// ---- what it reads

TEST_F(Evaluation, CommentsCommasAndHeadingsDoNotMatter) {
  std::string text = good_text().substr(good_text().find('\n') + 1);
  std::replace(text.begin(), text.end(), ' ', ',');
  write_text(path("table.csv"), "timestamp,tx,ty,tz,qx,qy,qz,qw\r\n# from a spreadsheet\n\n" + text);
  const Outcome commas = ate({path("table.csv"), "--json"});
  ASSERT_EQ(commas.exit_code, 0) << commas.err;
  EXPECT_EQ(json::parse(commas.out)["estimates"][0]["translation_m"],
            json::parse(ate({path("a/trajectory.txt"), "--json"}).out)["estimates"][0]["translation_m"]);
}

TEST_F(Evaluation, DoubledStampsAreLeftOutAndSaid) {
  write_text(path("twice.txt"), good_text() + good_text());
  const Outcome outcome = ate({path("twice.txt"), "--json"});
  EXPECT_EQ(json::parse(outcome.out)["estimates"][0]["pairs"], 100);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("twice.txt: the poses were not in order"), HasSubstr("100 poses")));
}

TEST_F(Evaluation, WhatIsNoTrajectoryIsSaidWithFileAndLine) {
  const std::string good = "1000 0 0 0 0 0 0 1\n", after = "1001 0 0 0 0 0 0 1\n";
  EXPECT_THAT(error_over(good + "1000.5 nan 0 0 0 0 0 1\n" + after),
              AllOf(HasSubstr("bad.txt:2: 'nan' is not a finite number"), HasSubstr("leave out")));
  EXPECT_THAT(error_over(good + "soon 0 0 0 0 0 0 1\n" + after), HasSubstr("bad.txt:2: 'soon' is not a time"));
  EXPECT_THAT(error_over(""), HasSubstr("bad.txt: has no poses"));
  EXPECT_THAT(error_over("# nothing but a comment\n"), HasSubstr("bad.txt: has no poses"));
  EXPECT_THAT(error_over("some,names,only\n"), HasSubstr("bad.txt: has no poses"));
  EXPECT_THAT(error_over(std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16)), HasSubstr("bad.txt"));
}

TEST_F(Evaluation, TooFewPairsAreCounted) {
  EXPECT_THAT(error_over("1000 0 0 0 0 0 0 1\n1000.5 1 0 0 0 0 0 1\n1010 1 0 0 0 0 0 1\n"),
              AllOf(HasSubstr("only 2 pairs of poses"), HasSubstr("at least 3")));
}

TEST_F(Evaluation, ClocksThatAreApartAreMeasured) {
  write_tum_trajectory(path("later.txt"), way(0, 500));
  for (const char* error : {"ate", "rpe"}) {
    const Outcome outcome = eval(error, {path("later.txt")});
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_THAT(outcome.err, HasSubstr("the estimate begins 496.700000 s after the reference ends"));
  }
}

TEST_F(Evaluation, FilesThatCannotBeReadOrWritten) {
  EXPECT_THAT(ate({path("none.txt")}).err, HasSubstr("none.txt: cannot be read"));
  EXPECT_THAT(ate({path("a")}).err, HasSubstr("no poses named frame-000000.pose.txt"));
  EXPECT_THAT(plumbline({"eval", "ate", path("none.txt"), truth()}).err, HasSubstr("none.txt: cannot be read"));
  EXPECT_THAT(ate({truth(), "--json", path("none/t.json")}).err, HasSubstr("create the folder"));
  const Outcome plot = ate({truth(), "--plot", path("plot.pdf")});
  EXPECT_EQ(plot.exit_code, 2);
  EXPECT_THAT(plot.err, HasSubstr(".svg or .png"));
  EXPECT_EQ(plot.out, "");
}

// ---- plots of what commands left

TEST_F(Evaluation, PlotsTheAngularTest) {
  const std::string head =
      "angle_deg,first,second,true_rotation_deg,true_translation_m,status,reason,orientation,translation_error_m,"
      "rotation_error_deg,success\n";
  write_text(path("a.csv"), head +
                                "10,0,1,10,0.1,tracked,,,0.002,0.1,1\n10,1,2,10,0.1,lost,few,,,,0\n"
                                "20,0,2,20,0.1,lost,few,,,,0\n");
  const Outcome outcome = plumbline({"plot", "--keep-script", "angles", path("a.csv"), "-o", path("angles.svg")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(read_text(path("angles.svg")), AllOf(HasSubstr(">a<"), HasSubstr(">paper, with IMU<")));
  EXPECT_THAT(read_text(path("angles.gp")), AllOf(HasSubstr("\n10 50\n20 100\n"), HasSubstr("\n10 2\n")));
  const Outcome other = plumbline({"plot", "angles", path("a/trajectory.txt"), "-o", path("b.svg")});
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_THAT(other.err, HasSubstr("no column 'angle_deg'"));
}

TEST_F(Evaluation, PlotsTheIterationsOfAFrame) {
  json dump = {{"frame", 7}, {"bin_width_m", 0.001}, {"iterations", json::array()}};
  for (int i = 0; i < 3; ++i) {
    std::vector<int> histogram(100, 0);
    histogram[static_cast<std::size_t>(30 - 10 * i)] = 500;
    dump["iterations"].push_back({{"level", i < 2 ? 2 : 1},
                                  {"pairs", 500},
                                  {"median_distance_m", 0.03 - 0.01 * i},
                                  {"rms_m", 0.02},
                                  {"histogram", histogram}});
  }
  write_text(path("icp_7.json"), dump.dump());
  const Outcome outcome = plumbline({"plot", "--keep-script", "icp", path("icp_7.json"), "-o", path("icp.svg")});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(read_text(path("icp.svg")),
              AllOf(HasSubstr("Frame 7"), HasSubstr("Distances at level 2"), HasSubstr("Distances at level 1")));
  EXPECT_THAT(read_text(path("icp.gp")), AllOf(HasSubstr("\n30.5 100\n"), HasSubstr("\n1 30\n2 20\n")));
  write_text(path("icp_7.json"), "{}");
  EXPECT_THAT(plumbline({"plot", "icp", path("icp_7.json"), "-o", path("icp.svg")}).err,
              HasSubstr("does not hold the iterations of a frame"));
}

TEST_F(Evaluation, PlotsARun) {
  write_text(
      path("a/frames.csv"),
      "index,status,inlier_fraction,median_distance_m,rms_m,seed_to_result_deg,total_ms,track_ms,integrate_ms,raycast_"
      "ms\n"
      "0,initialised,0,0,0,0,20,0,5,10\n1,tracked,0.5,0.004,0.005,1,20,5,5,10\n2,lost,0.1,0.02,0.03,9,9,9,0,0\n");
  write_text(path("a/summary.json"), json{{"ate", {{"groundtruth", truth()}}}}.dump());
  const Outcome outcome = plumbline({"plot", "run", path("a"), "-o", path("plots"), "--format", "png"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(fs::exists(path("plots/trajectory.png")) && fs::exists(path("plots/frames.png")));
  const Outcome alone = plumbline({"plot", "run", path("b")});
  EXPECT_EQ(alone.out, path("b/trajectory.svg") + "\n");
  EXPECT_THAT(read_text(path("b/trajectory.svg")), Not(HasSubstr(">truth<")));
  EXPECT_THAT(plumbline({"plot", "run", folder_}).err, HasSubstr("holds no frames.csv"));
}

}  // namespace
}  // namespace plumbline::test
