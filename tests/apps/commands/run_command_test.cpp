// `plumbline run` on good sequences: what it writes, says, and leaves alone.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "io/images/image_file.h"
#include "io/mesh.h"
#include "io/trajectory.h"
#include "plumbline/config.h"
#include "plumbline/evaluation.h"
#include "plumbline/image.h"
#include "plumbline/mesh.h"
#include "plumbline/se3.h"
#include "plumbline/trajectory.h"
#include "report/report.h"
#include "support/program.h"
#include "support/small_sequence.h"
#include "support/terminal.h"

namespace plumbline::test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::Ge;
using testing::HasSubstr;
using testing::Le;
using testing::Not;

using RunCommand = SmallSequence;

std::vector<std::vector<std::string>> read_csv(const std::string& path) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream text(read_text(path));
  for (std::string line; std::getline(text, line);) {
    rows.emplace_back();
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) rows.back().push_back(field);
  }
  return rows;
}

std::vector<std::string> column(const std::vector<std::vector<std::string>>& rows, const std::string& name) {
  const auto at = std::find(rows.at(0).begin(), rows[0].end(), name) - rows[0].begin();
  std::vector<std::string> values;
  for (std::size_t i = 1; i < rows.size(); ++i) values.push_back(rows[i].at(static_cast<std::size_t>(at)));
  return values;
}

nlohmann::json summary(const std::string& folder) { return nlohmann::json::parse(read_text(folder + "/summary.json")); }

std::vector<std::string> files_in(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

/// Share of triangles whose winding agrees with their vertices' normals.
double winding_agreement(const Mesh& mesh) {
  const auto vector = [](const Mesh::Float3& p) { return Eigen::Vector3d(p.x, p.y, p.z); };
  std::size_t agree = 0;
  for (const Mesh::Triangle& t : mesh.triangles) {
    const Eigen::Vector3d a = vector(mesh.positions[t.a]), b = vector(mesh.positions[t.b]),
                          c = vector(mesh.positions[t.c]);
    agree += (b - a).cross(c - a).dot(vector(mesh.normals[t.a])) > 0 ? 1 : 0;
  }
  return static_cast<double>(agree) / static_cast<double>(mesh.triangles.size());
}

/// What a run leaves, in order; a program that was built without the report leaves none.
std::vector<std::string> whole_set() {
  std::vector<std::string> files = {"config.toml", "frames.csv", "mesh.ply"};
  if (app::can_report()) files.emplace_back("report.html");
  files.insert(files.end(), {"summary.json", "trajectory.txt"});
  return files;
}

TEST_F(RunCommand, LeavesAWholeSetOfFilesThatReadBack) {
  const Outcome run = plumbline(small_run(sequence(), output()));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(files_in(output()), whole_set());

  const Trajectory estimate = read_tum_trajectory(output() + "/trajectory.txt");
  ASSERT_EQ(estimate.size(), static_cast<std::size_t>(kSmallFrames));
  const Trajectory truth = read_tum_trajectory(sequence() + "/groundtruth.txt");
  const double ate = eval::absolute_trajectory_error(truth, estimate).translation.rmse;
  EXPECT_LT(ate, 0.02);
  EXPECT_LT((estimate.front().world_from_camera.translation()).norm(), 1e-9);  // the world is the first camera's

  const Mesh mesh = read_ply(output() + "/mesh.ply");
  EXPECT_GT(mesh.triangles.size(), 1000u);
  EXPECT_EQ(mesh.normals.size(), mesh.positions.size());
  EXPECT_EQ(mesh.colors.size(), mesh.positions.size());
  EXPECT_GT(winding_agreement(mesh), 0.95);

  const auto rows = read_csv(output() + "/frames.csv");
  ASSERT_EQ(rows.size(), static_cast<std::size_t>(kSmallFrames) + 1);
  for (const auto& row : rows) EXPECT_EQ(row.size(), rows[0].size());
  const auto status = column(rows, "status");
  EXPECT_EQ(status.front(), "initialised");
  EXPECT_EQ(std::count(status.begin(), status.end(), "tracked"), kSmallFrames - 1);
  EXPECT_EQ(column(rows, "iterations_level2")[1], "0") << "40 columns are too few";
  EXPECT_THAT(std::stoi(column(rows, "iterations_level1")[1]), AllOf(Ge(3), Le(10)));
  EXPECT_GT(std::stoi(column(rows, "inliers")[1]), 1000);
  EXPECT_EQ(column(rows, "rank")[1], "6");
  EXPECT_GT(std::stod(column(rows, "total_ms")[1]), 0);

  const nlohmann::json json = summary(output());
  EXPECT_EQ(json["frames"], kSmallFrames);
  EXPECT_EQ(json["tracked"], kSmallFrames);
  EXPECT_EQ(json["lost"], 0);
  EXPECT_TRUE(json["error"].is_null());
  EXPECT_EQ(json["interrupted"], false);
  EXPECT_NEAR(json["ate"]["rmse_m"].get<double>(), ate, 1e-6);
  EXPECT_EQ(json["mesh"]["triangles"], mesh.triangles.size());
  EXPECT_EQ(json["volume"]["resolution"], 96);
  EXPECT_THAT(json["command"].get<std::string>(), HasSubstr("volume.side=4"));

  Parameters expected = preset("plumbline");
  for (const char* setting : {"volume.resolution=96", "volume.side=4", "volume.offset=0", "volume.truncation=0.1"})
    apply_setting(setting, &expected);
  EXPECT_EQ(read_text(output() + "/config.toml"), to_toml(expected));
}

TEST_F(RunCommand, SaysWhatItFoundAndHowItWent) {
  const Outcome run = plumbline(small_run(sequence(), output()));
  EXPECT_THAT(run.out,
              AllOf(HasSubstr("TUM RGB-D"), HasSubstr("camera-intrinsics.txt"), HasSubstr("160x120"),
                    HasSubstr("96x96x96 voxels"), HasSubstr("cpu ("), HasSubstr("10 of 10 frames"), HasSubstr("ATE")));
  EXPECT_THAT(run.err, AllOf(HasSubstr("frame 10/10"), Not(HasSubstr("\r")), Not(HasSubstr("\x1b"))));
}

TEST_F(RunCommand, QuietPrintsNothing) {
  const Outcome run = plumbline(small_run(sequence(), output(), {"--quiet"}));
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.out + run.err, "");
}

TEST_F(RunCommand, TheBarOnATerminalIsErased) {
  PLUMBLINE_TERMINAL_OR_SKIP();
  const Outcome run = plumbline_on_terminal(small_run(sequence(), output()));
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.err, AllOf(HasSubstr("["), HasSubstr("tracked, 0 lost"), HasSubstr("ETA")));
  EXPECT_THAT(run.err, testing::EndsWith("\r\x1b[K"));
  EXPECT_THAT(run.err, Not(HasSubstr("\n")));
}

TEST_F(RunCommand, ThreadsDoNotChangeABit) {
  for (const char* threads : {"1", "2", "7"}) {
    const Outcome run = plumbline(small_run(sequence(), path(threads), {"--threads", threads}));
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(read_text(path(threads) + "/trajectory.txt"), read_text(path("1") + "/trajectory.txt"));
    EXPECT_EQ(read_text(path(threads) + "/mesh.ply"), read_text(path("1") + "/mesh.ply"));
  }
}

TEST_F(RunCommand, StrideAndMaxFramesChooseFrames) {
  const Outcome run = plumbline(small_run(sequence(), output(), {"--stride", "3", "--max-frames", "3", "--no-mesh"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(column(read_csv(output() + "/frames.csv"), "index"), ElementsAre("0", "3", "6"));
  EXPECT_FALSE(std::filesystem::exists(output() + "/mesh.ply"));
}

TEST_F(RunCommand, InRealTimeEveryFrameIsTakenOrCountedAsDropped) {
  const Outcome run = plumbline(small_run(sequence(), output(), {"--realtime", "--speed", "0.5", "--no-mesh"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("dropped for lack of time"));
  const auto json = summary(output());
  EXPECT_EQ(json["live"]["captured"], kSmallFrames);
  EXPECT_EQ(column(read_csv(output() + "/frames.csv"), "index").size() + json["live"]["dropped"].get<std::size_t>(),
            std::size_t{kSmallFrames});
  EXPECT_THAT(plumbline(small_run(sequence(), output(), {"--realtime", "--speed", "0"})).err, HasSubstr("--speed"));
}

TEST_F(RunCommand, QualityChangesTheDefaultPresetAlone) {
  const auto settings = [](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"run", "--print-config"};
    words.insert(words.end(), more.begin(), more.end());
    return plumbline(words).out;
  };
  EXPECT_EQ(settings({"--quality", "balanced"}), settings({}));
  EXPECT_THAT(settings({"--quality", "fast"}), AllOf(HasSubstr("resolution = 384"), HasSubstr("finest_level = 2")));
  EXPECT_THAT(settings({"--quality", "best"}), HasSubstr("resolution = 768"));
  EXPECT_THAT(settings({"--quality", "best", "--set", "volume.resolution=100"}), HasSubstr("resolution = 100"));
  const Outcome unknown = plumbline({"run", "--print-config", "--quality", "finest"});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.err, AllOf(HasSubstr("'finest'"), HasSubstr("fast, balanced, best")));
  const Outcome published = plumbline({"run", "--print-config", "--preset", "paper", "--quality", "fast"});
  EXPECT_EQ(published.exit_code, 2);
  EXPECT_THAT(published.err, HasSubstr("--quality fast"));
}

TEST_F(RunCommand, AnInitialPoseMovesTheWholeResult) {
  const Outcome run =
      plumbline(small_run(sequence(), output(), {"--initial-pose", "1 2 3 0 0 0.70710678 0.70710678", "--no-mesh"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const SE3 first = read_tum_trajectory(output() + "/trajectory.txt").front().world_from_camera;
  EXPECT_LT((first.translation() - Eigen::Vector3d(1, 2, 3)).norm(), 1e-6);
  EXPECT_LT((first.rotation() * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 1e-6);
  const auto json = summary(output());
  EXPECT_LT(json["ate"]["rmse_m"].get<double>(), 0.02);
}

TEST_F(RunCommand, AConfigurationIsOverlaidByFileThenSettings) {
  write_text(path("my.toml"), "[tracking]\nnormal_gate = 25.0\niterations = [1, 2]\nconverged_step = 0.0\n");
  const Outcome run = plumbline(
      small_run(sequence(), output(), {"--config", path("my.toml"), "--set", "tracking.normal_gate=35", "--no-mesh"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  Parameters used;
  load_parameters(output() + "/config.toml", &used);
  EXPECT_EQ(used.tracking.normal_gate, 35);
  EXPECT_EQ(used.tracking.iterations, (std::vector<int>{1, 2}));
  const auto rows = read_csv(output() + "/frames.csv");
  EXPECT_EQ(column(rows, "iterations_level2")[1], "1");
  EXPECT_EQ(column(rows, "iterations_level1")[1], "2");
}

TEST_F(RunCommand, TheSavedConfigurationRepeatsTheRun) {
  ASSERT_EQ(plumbline(small_run(sequence(), output())).exit_code, 0);
  const Outcome again = plumbline({"run", sequence(), "-o", path("again"), "--config", output() + "/config.toml"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(read_text(path("again") + "/trajectory.txt"), read_text(output() + "/trajectory.txt"));
}

TEST_F(RunCommand, ASecondRunReplacesFilesWhole) {
  good_mesh();
  const Outcome run = plumbline(small_run(sequence(), output(), {"--max-frames", "4"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(read_tum_trajectory(output() + "/trajectory.txt").size(), 4u);
  EXPECT_EQ(read_csv(output() + "/frames.csv").size(), 5u);
  EXPECT_EQ(files_in(output()), whole_set());
}

TEST_F(RunCommand, NoColorGivesAMeshWithoutColors) {
  const Outcome run = plumbline(small_run(sequence(), output(), {"--no-color"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("no colour"));
  EXPECT_TRUE(read_ply(output() + "/mesh.ply").colors.empty());
}

// ---- with an orientation sensor -------------------------------------------------------------------------------------

TEST_F(RunCommand, UsesAnOrientationFile) {
  const std::string truth = sequence() + "/groundtruth.txt";
  const Outcome run = plumbline(small_run(
      sequence(), output(), {"--orientation", truth, "--imu-model", "bno055", "--imu-seed", "2", "--no-mesh"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("orientation"), HasSubstr("bno055"), HasSubstr("sensor")));
  const auto rows = read_csv(output() + "/frames.csv");
  const auto use = column(rows, "orientation");
  EXPECT_EQ(use.front(), "first");
  EXPECT_EQ(std::count(use.begin(), use.end(), "used"), kSmallFrames - 1);
  EXPECT_GT(std::stod(column(rows, "seed_deg")[1]), 0);
  EXPECT_LT(std::stod(column(rows, "seed_to_result_deg")[1]), 3);
  const auto json = summary(output());
  EXPECT_EQ(json["orientation"]["used"], kSmallFrames - 1);
  EXPECT_THAT(json["orientation"]["source"].get<std::string>(), HasSubstr("bno055"));
  EXPECT_LT(json["ate"]["rmse_m"].get<double>(), 0.02);
}

TEST_F(RunCommand, AFrameWithoutAReadingSaysWhy) {
  // Readings of the second half only.
  const Trajectory truth = read_tum_trajectory(sequence() + "/groundtruth.txt");
  write_tum_trajectory(path("late.txt"),
                       Trajectory(truth.begin() + static_cast<std::ptrdiff_t>(truth.size() / 2), truth.end()));
  const Outcome run = plumbline(small_run(sequence(), output(), {"--orientation", path("late.txt"), "--no-mesh"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto use = column(read_csv(output() + "/frames.csv"), "orientation");
  EXPECT_EQ(use.front(), "before the orientation's start");
  EXPECT_EQ(use.back(), "used");
  EXPECT_EQ(summary(output())["lost"], 0);
  EXPECT_THAT(run.out, HasSubstr("the sensor's readings lie at")) << "and the start says so, too";
}

TEST_F(RunCommand, ReadingsThatLieAtNoFrameAreAnError) {
  Trajectory truth = read_tum_trajectory(sequence() + "/groundtruth.txt");
  for (StampedPose& pose : truth) pose.time += from_seconds(500);
  write_tum_trajectory(path("shifted.txt"), truth);
  const auto words = small_run(sequence(), output(), {"--orientation", path("shifted.txt"), "--no-mesh"});
  const Outcome run = plumbline(words);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, AllOf(HasSubstr("no reading lies at any frame"), HasSubstr("--orientation-offset -500")));
  for (StampedPose& pose : truth) pose.time = 1000 * (pose.time - from_seconds(500));
  write_tum_trajectory(path("shifted.txt"), truth);
  EXPECT_THAT(plumbline(words).err, HasSubstr("seem to be in milliseconds"));
  for (StampedPose& pose : truth) pose.time += from_seconds(1e6);
  write_tum_trajectory(path("shifted.txt"), truth);
  EXPECT_THAT(plumbline(words).err,
              AllOf(HasSubstr("by their span"), HasSubstr("milliseconds"), HasSubstr("another moment")));
}

TEST_F(RunCommand, ASensorOfTheRecordingThatIsNotUsedSaysWhy) {
  std::ofstream tilt(sequence() + "/accelerometer.txt");
  tilt << "# timestamp ax ay az\n";
  for (int i = 0; i < 100; ++i) tilt << 0.01 * i << " 0 9.8 0\n";
  tilt.close();
  const Outcome run = plumbline(small_run(sequence(), output(), {"--no-mesh"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("accelerometer.txt): not used, because it gives the tilt alone")));
  EXPECT_THAT(summary(output())["sequence"]["notes"].dump(), HasSubstr("not used, because"));
  EXPECT_TRUE(summary(output())["orientation"].is_null());
  const Outcome none = plumbline(small_run(sequence(), output(), {"--orientation", "none", "--no-mesh"}));
  EXPECT_THAT(none.out, Not(HasSubstr("not used")));
}

TEST_F(RunCommand, TheRecordingsOwnSensorServesByItself) {
  // StrayScanner's file tells how the phone's sensor sits.
  std::ofstream imu(sequence() + "/imu.csv");
  imu << "timestamp, a_x, a_y, a_z, alpha_x, alpha_y, alpha_z\n";
  const Trajectory truth = read_tum_trajectory(sequence() + "/groundtruth.txt");
  for (double t = to_seconds(truth.front().time) - 0.5; t < to_seconds(truth.back().time) + 0.5; t += 0.01)
    imu << fmt::format("{:.3f}, 0.01, -0.7, -0.7, 0, 0, 0\n", t);
  imu.close();
  const Outcome run = plumbline(small_run(sequence(), output(), {"--no-mesh"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("the recording's own sensor"), HasSubstr("--mounting")));
  EXPECT_THAT(summary(output())["orientation"]["source"].get<std::string>(), HasSubstr("imu.csv"));
}

TEST_F(RunCommand, ASensorThatNoParameterUsesIsTold) {
  const Outcome run =
      plumbline(small_run(sequence(), output(),
                          {"--orientation", sequence() + "/groundtruth.txt", "--preset", "kinectfusion", "--no-mesh"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("leave the orientation unused"));
}

TEST_F(RunCommand, TheIterationsOfAFrameCanBeLookedAt) {
  const Outcome run = plumbline(small_run(sequence(), output(),
                                          {"--preset", "paper", "--orientation", sequence() + "/groundtruth.txt",
                                           "--dump-icp", "0", "--dump-icp", "4", "--no-mesh"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("frame 0 was not registered"));
  const auto json = nlohmann::json::parse(read_text(output() + "/icp_4.json"));
  EXPECT_EQ(json["frame"], 4);
  EXPECT_EQ(json["orientation"], "used");
  ASSERT_GE(json["iterations"].size(), 3u);
  for (const auto& iteration : json["iterations"]) {
    int pairs = 0;
    for (const int count : iteration["histogram"]) pairs += count;
    EXPECT_EQ(pairs, iteration["pairs"]);
    const double fraction = iteration["matched_fraction"];
    EXPECT_NEAR(iteration["lambda"].get<double>(), 2 / std::sqrt(fraction), 1e-9);
    EXPECT_EQ(iteration["step_rotation_rad"].size(), 3u);
  }
}

TEST_F(RunCommand, PixelUseIsPaintedForTheFramesAskedFor) {
  const Outcome run =
      plumbline(small_run(sequence(), output(), {"--dump-pixel-use", "0", "--dump-pixel-use", "5", "--no-mesh"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("frame 0 was not registered"));
  EXPECT_FALSE(std::filesystem::exists(output() + "/pixel_use_0.png"));
  const ColorImage picture = read_color_image(output() + "/pixel_use_5.png");
  ASSERT_EQ(picture.width, 80) << "at the finest level that is tracked";
  ASSERT_EQ(picture.height, 60);
  std::size_t used = 0;
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 80; ++x) used += picture.at(x, y, 0) == 64 && picture.at(x, y, 1) == 160 ? 1 : 0;
  }
  EXPECT_GT(used, 1250u);
}

TEST_F(RunCommand, AnotherGroundTruthCanBeNamed) {
  std::filesystem::rename(sequence() + "/groundtruth.txt", path("truth.txt"));
  const Outcome run = plumbline(small_run(sequence(), output(), {"--groundtruth", path("truth.txt"), "--no-mesh"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto json = summary(output());
  EXPECT_EQ(json["ate"]["groundtruth"], path("truth.txt"));
  EXPECT_EQ(json["ate"]["pairs"], kSmallFrames);
  const Outcome without = plumbline(small_run(sequence(), output(), {"--no-mesh"}));
  EXPECT_TRUE(summary(output())["ate"].is_null());
  EXPECT_THAT(without.out, Not(HasSubstr("ATE")));
}

TEST_F(RunCommand, AReaderThatWentAwayDoesNotStopTheRun) {
  Launch launch;
  launch.close_stdout_reader = true;
  const Outcome run = plumbline(small_run(sequence(), output()), launch);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(std::filesystem::exists(output() + "/summary.json"));
}

/// A sequence that takes long: the same images over and over, to and fro.
void make_long(const std::string& sequence, int frames) {
  std::ostringstream list;
  constexpr int kPeriod = 2 * (kSmallFrames - 1);
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(sequence + "/depth"))
    names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  for (int i = 0; i < frames; ++i) {
    const int k = i % kPeriod < kSmallFrames ? i % kPeriod : kPeriod - i % kPeriod;
    list << 100 + i / 30.0 << " depth/" << names[static_cast<std::size_t>(k)] << '\n';
  }
  write_text(sequence + "/depth.txt", list.str());
}

/// Lines of a file that another process writes, once there are at least so many; fewer after a minute.
std::size_t wait_for_lines(const std::string& path, std::size_t lines) {
  std::size_t seen = 0;
  for (int i = 0; i < 600 && seen < lines; ++i) {
    const std::string text = read_text(path);
    seen = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return seen;
}

class Interrupted : public RunCommand, public testing::WithParamInterface<int> {};

TEST_P(Interrupted, ARunFinishesItsFrameAndWritesEverything) {
  constexpr int kFrames = 20000;
  make_long(sequence(), kFrames);
  Running running(small_run(sequence(), output()));
  ASSERT_GE(wait_for_lines(output() + "/frames.csv.partial", 6), 6u);
  ASSERT_EQ(kill(running.pid(), GetParam()), 0);
  const Outcome run = running.wait();
  EXPECT_EQ(run.exit_code, 128 + GetParam()) << run.err;
  EXPECT_EQ(files_in(output()), whole_set());
  const auto json = summary(output());
  EXPECT_EQ(json["interrupted"], true);
  const auto frames = json["frames"].get<std::size_t>();
  EXPECT_GE(frames, 5u);
  EXPECT_LT(frames, static_cast<std::size_t>(kFrames));
  EXPECT_EQ(read_csv(output() + "/frames.csv").size(), frames + 1);
  EXPECT_EQ(read_tum_trajectory(output() + "/trajectory.txt").size(), json["tracked"].get<std::size_t>());
  EXPECT_GT(read_ply(output() + "/mesh.ply").triangles.size(), 1000u);
}

INSTANTIATE_TEST_SUITE_P(Signals, Interrupted, testing::Values(SIGINT, SIGTERM));

TEST_F(RunCommand, AKilledRunLeavesItsRowsAndTheOldFiles) {
  const std::string mesh = good_mesh(), frames = read_text(output() + "/frames.csv");
  make_long(sequence(), 20000);
  Running running(small_run(sequence(), output()));
  ASSERT_GE(wait_for_lines(output() + "/frames.csv.partial", 6), 6u);
  ASSERT_EQ(kill(running.pid(), SIGKILL), 0);
  EXPECT_EQ(running.wait().exit_code, 1000 + SIGKILL);
  EXPECT_EQ(read_text(output() + "/mesh.ply"), mesh);
  EXPECT_EQ(read_text(output() + "/frames.csv"), frames);
  EXPECT_GE(read_csv(output() + "/frames.csv.partial").size(), 6u);
}

}  // namespace
}  // namespace plumbline::test
