// The paper's tables: the uncertainty study against the error model itself, and the commands on a small sequence.
#include "lab/reproduce.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "plumbline/angles.h"
#include "plumbline/se3.h"
#include "sensor/error_model.h"
#include "support/program.h"
#include "support/small_sequence.h"

namespace plumbline::test {
namespace {

namespace fs = std::filesystem;
using app::Table;
using testing::HasSubstr;

const Table& table_named(const app::ReproduceResult& result, const std::string& name) {
  return *std::find_if(result.tables.begin(), result.tables.end(), [&](const Table& t) { return t.name == name; });
}

TEST(Uncertainty, FindsTheErrorModelThatTheSensorHas) {
  app::ReproduceOptions options;
  options.seeds = 1;
  const app::Plan plan = app::plan_uncertainty(options);
  EXPECT_TRUE(plan.sequences.empty() && plan.runs.empty() && plan.timed.empty());
  const app::ReproduceResult result = plan.result();
  const Table& points = table_named(result, "uncertainty_points");
  ASSERT_EQ(points.rows.size(), 3U * 73U);
  const SystematicError truth(error_model("bno055").amplitude, 3, 1);
  const std::map<std::string, int> axes = {{"X", 0}, {"Y", 1}, {"Z", 2}};
  double largest[3] = {};
  for (const auto& row : points.rows) {
    const int axis = axes.at(row[1].text);
    const double angle = *row[2].value, systematic = *row[3].value, random = *row[4].value;
    EXPECT_LT(random, 1e-6);
    largest[axis] = std::max(largest[axis], std::abs(systematic));
    if (std::abs(angle) > 90) continue;  // near half a turn the error about the other axes fades
    const Eigen::Matrix3d at = so3::exp(Eigen::Vector3d(Eigen::Vector3d::Unit(axis) * angle * kRadiansPerDegree));
    EXPECT_NEAR(systematic, truth.at(at)[axis] / kRadiansPerDegree, 1e-6);
  }
  EXPECT_NEAR(largest[0], 3, 0.15);  // the paper's amplitudes, met between two steps of 5°
  EXPECT_NEAR(largest[1], 3, 0.15);
  EXPECT_NEAR(largest[2], 10, 0.5);
  ASSERT_EQ(result.plots.size(), 1U);
  EXPECT_EQ(result.plots[0].second.panels.size(), 6U);
}

TEST(PaperDatasets, HaveTheMeansThatThePaperPrints) {
  double ate[3] = {}, rpe[3] = {}, frames = 0;
  for (const app::PaperDataset& dataset : app::paper_datasets()) {
    for (int i = 0; i < 3; ++i) ate[i] += dataset.ate[i] / 11, rpe[i] += dataset.rpe[i] / 11;
    frames += dataset.frames;
  }
  EXPECT_NEAR(ate[0], 0.664843727, 1e-8);
  EXPECT_NEAR(ate[1], 0.219829545, 1e-8);
  EXPECT_NEAR(ate[2], 0.309310636, 1e-8);
  EXPECT_NEAR(rpe[0], 0.621532545, 1e-8);
  EXPECT_NEAR(rpe[1], 0.477241636, 1e-8);
  EXPECT_NEAR(rpe[2], 0.493541727, 1e-8);
  EXPECT_EQ(frames, 15793);
}

TEST(Seeds, AreOfSensorsThatHaveAnError) {
  EXPECT_EQ(app::seeds_of("none", 5).size(), 1U);
  EXPECT_EQ(app::seeds_of("ideal", 5).size(), 1U);
  EXPECT_EQ(app::seeds_of("bno055", 3), (std::vector<int>{1, 2, 3}));
}

TEST(Means, LeaveNothingHardOut) {
  EXPECT_EQ(app::mean_if_complete({1.0, 3.0}), 2.0);
  EXPECT_FALSE(app::mean_if_complete({1.0, std::nullopt}));
  EXPECT_FALSE(app::mean_if_complete({}));
}

/// The small sequence in the place of fr1/xyz.
class Reproduce : public SmallSequence {
 protected:
  Reproduce() {
    fs::create_directories(path("data/tum"));
    fs::rename(sequence(), path("data/tum/rgbd_dataset_freiburg1_xyz"));
  }
  Outcome reproduce(const std::vector<std::string>& more) const {
    std::vector<std::string> words = {"reproduce", "--data", path("data"), "-o", output(), "--seeds", "1"};
    words.insert(words.end(), more.begin(), more.end());
    return plumbline(words);
  }
  std::string written(const std::string& name) const { return read_text(output() + "/" + name); }
};

TEST_F(Reproduce, AteAndIterationsBesideThePapersNumbers) {
  const std::vector<std::string> words = {"ate", "iterations", "timing", "--frames", "3", "--timed-frames", "3"};
  const Outcome first = reproduce(words);
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.out, HasSubstr("dataset"));
  const app::CsvRows ate(output() + "/ate.csv"), times(output() + "/iterations.csv");
  ASSERT_EQ(ate.size(), 4U);  // the dataset, the mean, two improvements
  EXPECT_EQ(ate.text(0, "dataset"), "fr1/xyz");
  EXPECT_EQ(ate.number(0, "paper ATE Orig."), 0.02201);
  EXPECT_EQ(ate.number(0, "paper RPE +noise"), 0.44321);
  const app::RunFigures run = app::run_figures(output() + "/runs/freiburg1_xyz-3-kinectfusion-none-1");
  EXPECT_EQ(run.frames, 3);
  EXPECT_NEAR(ate.number(0, "ATE Orig."), *run.ate_all, 1e-9);
  EXPECT_NEAR(ate.number(2, "paper ATE IMU"), -66.9351, 1e-3);
  EXPECT_EQ(times.number(0, "iterations Original"), 19);
  EXPECT_GT(times.number(0, "plumbline"), 0);
  EXPECT_EQ(times.number(0, "paper Fixed"), 26.3536);
  for (const char* figure : {"ate.svg", "iterations.svg"}) EXPECT_THAT(written(figure), HasSubstr("<svg")) << figure;
  EXPECT_THAT(written("reproduce.md"), testing::AllOf(HasSubstr("**ATE and RPE"), HasSubstr("K6000")));

  const Outcome second = reproduce(words);
  EXPECT_EQ(second.exit_code, 0);
  EXPECT_THAT(second.out, testing::AllOf(HasSubstr("6 of 6 runs are finished already"),
                                         HasSubstr("5 of 5 timed runs are finished already")));
}

TEST_F(Reproduce, AMissingRunIsADashAndNamed) {
  fs::remove(path("data/tum/rgbd_dataset_freiburg1_xyz/groundtruth.txt"));
  const Outcome outcome = reproduce({"ate", "--frames", "3"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("freiburg1_xyz-3-paper-ideal-1"));
  const app::CsvRows ate(output() + "/ate.csv");
  EXPECT_EQ(ate.text(0, "ATE IMU"), "");
  EXPECT_EQ(ate.number(0, "paper ATE IMU"), 0.017639);
}

TEST_F(Reproduce, AnglesOfSimulatedPairs) {
  const Outcome outcome = reproduce({"angles", "--scenes", "desk", "--angles", "5", "--pairs", "2"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const app::CsvRows table(output() + "/angles.csv");
  ASSERT_EQ(table.size(), 6U + 2U);
  for (std::size_t row = 0; row < 6; ++row) {
    EXPECT_GE(table.number(row, "5°"), 0);
    EXPECT_LE(table.number(row, "5°"), 100);
  }
  EXPECT_EQ(table.text(6, "scene"), "paper: Desktop");
  EXPECT_EQ(table.number(6, "5°"), 0);
}

TEST_F(Reproduce, SaysWhatIsMissing) {
  EXPECT_EQ(plumbline({"reproduce"}).exit_code, 2);
  EXPECT_EQ(reproduce({"everything"}).exit_code, 2);
  const Outcome outcome = plumbline({"reproduce", "ate", "--data", path("data") + "/trajectories", "-o", output()});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("--data"));
}

}  // namespace
}  // namespace plumbline::test
