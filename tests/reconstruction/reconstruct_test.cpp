#include "plumbline/reconstruct.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <string>
#include <vector>

#include "plumbline/error.h"
#include "plumbline/evaluation.h"
#include "plumbline/files.h"
#include "plumbline/simulate.h"
#include "support/error_of.h"
#include "support/temp_folder.h"

namespace plumbline {
namespace {

using test::error_of;
using test::TempFolder;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/// A simulated recording that all tests read.
class Reconstruct : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    SimulateOptions options;
    options.frames = 10;
    options.camera = {131.25f, 131.25f, 79.5f, 59.5f, 160, 120};
    truth_ = new Simulation(simulate(*folder_ / "recording", options));
  }
  static void TearDownTestSuite() {
    delete truth_;
    delete folder_;
  }

  static ReconstructOptions small() {
    ReconstructOptions options;
    options.parameters.volume.resolution = 128;
    options.parameters.volume.side = 4;
    return options;
  }

  static inline TempFolder* folder_ = nullptr;
  static inline Simulation* truth_ = nullptr;
  std::unique_ptr<Sequence> sequence_ = open_sequence(*folder_ / "recording");
};

TEST_F(Reconstruct, IsWhatAPipelineMakesOfTheFrames) {
  ReconstructOptions options = small();
  options.sensor = SensorReadings();
  options.final_fusion = false;
  const Reconstruction run = reconstruct(*sequence_, options);
  const auto backend = make_backend();
  Pipeline pipeline(options.parameters, sequence_->info().camera, *backend, SE3(), true);
  ASSERT_EQ(run.frames.size(), 10u);
  for (int i = 0; i < sequence_->size(); ++i) {
    const FrameReport report = pipeline.process(sequence_->read(i));
    EXPECT_EQ(report.world_from_camera.translation(),
              run.frames[static_cast<std::size_t>(i)].world_from_camera.translation());
  }
  EXPECT_EQ(run.mesh.positions.size(), pipeline.extract_mesh().positions.size());
  EXPECT_EQ(run.volume_side, pipeline.volume_side());
  EXPECT_EQ(run.tracked(), 10);
  EXPECT_FALSE(run.fusion);
  options.final_fusion = true;
  const Reconstruction fine = reconstruct(*sequence_, options);
  ASSERT_TRUE(fine.fusion) << fine.fusion_note;
  EXPECT_GT(fine.mesh.positions.size(), 4 * run.mesh.positions.size());
  EXPECT_TRUE(run.orientation.empty());
  EXPECT_LT(eval::absolute_trajectory_error(truth_->world_from_camera, run.trajectory).translation.rmse, 0.02);
}

/// To and fro before a desk: half of it is seen a second time.
TEST(ReconstructWithLoops, CorrectsThePathAndKeepsWhatWasTracked) {
  const TempFolder folder;
  SimulateOptions simulated;
  simulated.path = "orbit";
  simulated.rate = 6;
  simulated.camera = {262.5f, 262.5f, 159.5f, 119.5f, 320, 240};
  simulated.color = false;
  simulate(folder / "recording", simulated);
  const auto sequence = open_sequence(folder / "recording");
  ReconstructOptions options;
  options.parameters.volume.resolution = 256;
  options.parameters.volume.side = 5;
  options.sensor = SensorReadings();
  options.mesh = false;
  const auto run_with = [&](GlobalCorrection correction) {
    options.global = correction;
    return reconstruct(*sequence, options);
  };
  const Reconstruction off = run_with(GlobalCorrection::off), on = run_with(GlobalCorrection::on);
  EXPECT_FALSE(off.loops);
  EXPECT_TRUE(off.live_trajectory.empty());
  ASSERT_TRUE(on.loops);
  ASSERT_TRUE(on.loops->is_applied) << on.loops->note;
  ASSERT_EQ(on.live_trajectory.size(), off.trajectory.size());
  for (std::size_t i = 0; i < off.trajectory.size(); ++i) {
    EXPECT_EQ(on.live_trajectory[i].world_from_camera.translation(), off.trajectory[i].world_from_camera.translation());
    EXPECT_EQ(on.frames[i].world_from_camera.translation(), on.trajectory[i].world_from_camera.translation());
  }
  EXPECT_GT(on.loops->max_translation, 0);
  write_reconstruction(folder / "out", on);
  EXPECT_EQ(read_trajectory(folder / "out/trajectory_live.txt").size(), off.trajectory.size());
  // Published methods know no places.
  options.parameters.tracking.relocalise_after = 0;
  EXPECT_FALSE(run_with(GlobalCorrection::automatic).loops);
}

TEST_F(Reconstruct, TakesTheRecordingsSensorAndSaysSo) {
  std::vector<std::string> lines;
  ReconstructOptions options = small();
  options.log = [&](LogLevel, const std::string& line) { lines.push_back(line); };
  const Reconstruction run = reconstruct(*sequence_, options);
  EXPECT_THAT(run.orientation, HasSubstr("the recording's own sensor"));
  EXPECT_THAT(lines, Contains(HasSubstr("orientation: the recording's own sensor")));
  EXPECT_EQ(run.frames.back().orientation, OrientationUse::used);
}

TEST_F(Reconstruct, TakesAFilesReadings) {
  ReconstructOptions options = small();
  options.sensor = read_sensor(*folder_ / "recording/orientation.txt");
  EXPECT_FALSE(options.sensor->inertial.has_value());
  EXPECT_EQ(reconstruct(*sequence_, options).frames.back().orientation, OrientationUse::used);
  const std::vector<OrientationSample> samples = options.sensor->orientation->samples();
  options.sensor->orientation.emplace(samples, OrientationStreamOptions{.time_offset = 1e4});
  EXPECT_THAT(error_of([&] { reconstruct(*sequence_, options); }),
              AllOf(HasSubstr("no reading lies at any frame"), HasSubstr("orientation.txt")));
}

TEST_F(Reconstruct, ASensorOfAnotherFormSaysWhyItIsNotUsed) {
  EXPECT_TRUE(recorded_sensor(*sequence_).unused.empty());
  std::filesystem::copy(*folder_ / "recording", *folder_ / "unmounted", std::filesystem::copy_options::recursive);
  std::filesystem::remove(*folder_ / "unmounted/camera.json");
  SequenceOptions options;
  options.intrinsics = sequence_->info().camera;
  const auto unmounted = open_sequence(*folder_ / "unmounted", options);
  const SensorReadings readings = recorded_sensor(*unmounted);
  EXPECT_FALSE(readings.orientation.has_value());
  EXPECT_THAT(readings.unused, HasSubstr("nothing says how it sits on the camera"));
  SensorOptions mounted;
  mounted.has_mounting = true;
  EXPECT_TRUE(recorded_sensor(*unmounted, mounted).orientation.has_value());
}

TEST_F(Reconstruct, FramesAreChosenWatchedAndEnded) {
  std::vector<int> seen;
  ReconstructOptions options = small();
  options.mesh = false;
  options.frames = {1, 3, 5, 7};
  options.on_frame = [&](const Frame& frame, const FrameReport& report) {
    EXPECT_EQ(frame.time, report.time);
    seen.push_back(report.index);
  };
  options.stopping = [&] { return seen.size() == 3; };
  const Reconstruction run = reconstruct(*sequence_, options);
  EXPECT_THAT(seen, ElementsAre(1, 3, 5));
  EXPECT_THAT(run.mesh.triangles, IsEmpty());
  for (const std::vector<int>& wrong : std::vector<std::vector<int>>{{3, 1}, {1, 1}, {-1}, {10}}) {
    options.frames = wrong;
    EXPECT_THAT(error_of([&] { reconstruct(*sequence_, options); }), HasSubstr("Give indices from 0 to 9, each once."));
  }
}

TEST_F(Reconstruct, IsWrittenAndReadBack) {
  const Reconstruction run = reconstruct(*sequence_, small());
  write_reconstruction(*folder_ / "out/of/it", run);
  EXPECT_EQ(read_trajectory(*folder_ / "out/of/it/trajectory.txt").size(), run.trajectory.size());
  EXPECT_EQ(read_mesh(*folder_ / "out/of/it/mesh.ply").triangles.size(), run.mesh.triangles.size());
  EXPECT_TRUE(std::filesystem::exists(*folder_ / "out/of/it/config.toml"));
}

TEST(Simulate, RefusesWhatIsOutOfRange) {
  const TempFolder folder;
  SimulateOptions options;
  options.rate = 0;
  EXPECT_THAT(error_of([&] { simulate(folder / "x", options); }), HasSubstr("must be greater than 0"));
  options = {};
  options.camera.width = 0;
  EXPECT_THAT(error_of([&] { simulate(folder / "x", options); }), HasSubstr("the camera has no pixels"));
  options = {};
  options.path = "spiral";
  EXPECT_THAT(error_of([&] { simulate(folder / "x", options); }), HasSubstr("there is no such path"));
  EXPECT_FALSE(std::filesystem::exists(folder / "x"));
}

}  // namespace
}  // namespace plumbline
