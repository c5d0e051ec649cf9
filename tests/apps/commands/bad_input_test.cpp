// Bad input and bad surroundings, each with its message and exit code, and nothing lost that was there.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>

#include "io/images/png.h"
#include "io/mesh.h"
#include "io/trajectory.h"
#include "plumbline/image.h"
#include "support/program.h"
#include "support/small_disk.h"
#include "support/small_sequence.h"

namespace plumbline::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

class BadInput : public SmallSequence {
 protected:
  Outcome run(const std::vector<std::string>& more = {}) const {
    return plumbline(small_run(sequence(), output(), more));
  }

  /// Every failure says so on stderr, first thing in its line, with an advice below it.
  static void expect_error(const Outcome& outcome, int code, const std::vector<std::string>& words) {
    EXPECT_EQ(outcome.exit_code, code) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("plumbline: error: "));
    EXPECT_THAT(outcome.err, HasSubstr("\n  "));
    for (const std::string& word : words) EXPECT_THAT(outcome.err, HasSubstr(word));
  }

  /// One bad frame is named, counted and skipped; the run ends with success.
  void expect_skipped(const std::string& image, const std::string& why) const {
    const Outcome outcome = run();
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(outcome.err, AllOf(HasSubstr("skipped"), HasSubstr(image), HasSubstr(why)));
    EXPECT_EQ(summary()["frames"], kSmallFrames - 1);
    ASSERT_EQ(summary()["skipped_frames"].size(), 1u);
    EXPECT_THAT(summary()["skipped_frames"][0].get<std::string>(), HasSubstr(image));
  }

  /// Spoils a list: gets its lines, without the heading.
  template <class Change>
  void change_depth_list(Change&& change) const {
    std::istringstream text(read_text(sequence() + "/depth.txt"));
    std::vector<std::string> lines;
    for (std::string line; std::getline(text, line);)
      if (line.front() != '#') lines.push_back(line);
    change(lines);
    std::string joined;
    for (const std::string& line : lines) joined += line + "\n";
    write_text(sequence() + "/depth.txt", joined);
  }

  nlohmann::json summary() const { return nlohmann::json::parse(read_text(output() + "/summary.json")); }
};

// ---- The sequence ----

TEST_F(BadInput, MissingFolder) {
  expect_error(plumbline(small_run(path("nowhere"), output())), 1, {path("nowhere")});
  EXPECT_FALSE(fs::exists(output()));
}

TEST_F(BadInput, FolderWithoutASequence) {
  fs::create_directory(path("empty"));
  expect_error(plumbline(small_run(path("empty"), output())), 1, {path("empty")});
}

TEST_F(BadInput, EmptyDepthList) {
  write_text(sequence() + "/depth.txt", "");
  expect_error(run(), 1, {"depth.txt"});
  write_text(sequence() + "/depth.txt", "# timestamp filename\n");
  expect_error(run(), 1, {"depth.txt"});
}

TEST_F(BadInput, HalfWrittenLastLineOfTheDepthListIsLeftOut) {
  std::string list = read_text(sequence() + "/depth.txt");
  write_text(sequence() + "/depth.txt", list + "1.4");
  const Outcome outcome = run({"--no-mesh"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("note"), HasSubstr("10 of 10 frames")));
}

TEST_F(BadInput, MalformedLineOfTheDepthListIsNamed) {
  change_depth_list([](auto& lines) { lines[3] = "when? depth/x.png"; });
  expect_error(run(), 1, {"depth.txt:4"});
}

TEST_F(BadInput, StampsOutOfOrderAndDoubledAreRepairedAndSaid) {
  change_depth_list([](auto& lines) {
    std::swap(lines[2], lines[7]);
    lines.push_back(lines[0]);
  });
  const Outcome outcome = run({"--no-mesh"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("run backwards in"), HasSubstr("sorted"), HasSubstr("10 of 10 frames")));
  EXPECT_LT(summary()["ate"]["rmse_m"].get<double>(), 0.02);
}

TEST_F(BadInput, ColourThatIsNeverNearInTimeIsSaid) {
  std::string list = read_text(sequence() + "/rgb.txt");
  for (std::size_t at = list.find("\n1."); at != std::string::npos; at = list.find("\n1.", at + 1)) list[at + 1] = '7';
  write_text(sequence() + "/rgb.txt", list);
  const Outcome outcome = run();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("no colour"), HasSubstr("note")));
}

// ---- The images ----

TEST_F(BadInput, ATruncatedImageCostsThatFrame) {
  const std::string image = depth_images()[6];
  fs::resize_file(image, fs::file_size(image) / 2);
  expect_skipped(image, "truncated");
  EXPECT_EQ(read_tum_trajectory(output() + "/trajectory.txt").size(), 9u);
  EXPECT_GT(read_ply(output() + "/mesh.ply").triangles.size(), 1000u);
}

TEST_F(BadInput, AnUnreadableFirstImageCostsThatFrame) {
  write_text(depth_images()[0], "not a picture");
  expect_skipped(depth_images()[0], "neither a PNG");
}

TEST_F(BadInput, AnEightBitDepthImageCostsThatFrame) {
  write_color_png(depth_images()[0], ColorImage(160, 120, 1));
  expect_skipped(depth_images()[0], "16-bit grey depth is expected");
}

TEST_F(BadInput, AnImageOfAnotherSizeCostsThatFrame) {
  write_depth_png(depth_images()[4], DepthImage(80, 60));
  expect_skipped(depth_images()[4], "80x60");
}

TEST_F(BadInput, MostlyUnreadableImagesAreAnError) {
  for (std::size_t i = 0; i < 8; ++i) write_text(depth_images()[i], "not a picture");
  expect_error(run(), 1, {"neither a PNG"});
}

TEST_F(BadInput, AMissingImageIsLeftOutAndSaid) {
  fs::remove(depth_images()[5]);
  const Outcome outcome = run({"--no-mesh"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("note"), HasSubstr("9 of 9 frames")));
}

TEST_F(BadInput, NoDepthAtAll) {
  const std::string mesh = good_mesh();
  for (const std::string& image : depth_images()) write_depth_png(image, DepthImage(160, 120));
  expect_error(run(), 1, {"only 0.0 % of the pixels have a reading", "--depth-scale"});
  EXPECT_TRUE(read_text(output() + "/mesh.ply") == mesh);
}

TEST_F(BadInput, OneFrameWithoutDepthIsOnlyLost) {
  write_depth_png(depth_images()[5], DepthImage(160, 120));
  const Outcome outcome = run({"--no-mesh"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("frame 5 lost"), HasSubstr("frame 6 tracked again")));
  EXPECT_EQ(summary()["lost"], 1);
  EXPECT_EQ(summary()["lost_frames"], nlohmann::json({5}));
  EXPECT_EQ(read_tum_trajectory(output() + "/trajectory.txt").size(), static_cast<std::size_t>(kSmallFrames) - 1);
}

TEST_F(BadInput, ASceneBeyondTheVolume) {
  const std::string mesh = good_mesh();
  expect_error(run({"--set", "volume.side=0.5", "--set", "volume.truncation=0.05", "--set", "volume.offset=-2"}), 1,
               {"no frame could be tracked", "volume.placement=fit"});
  EXPECT_EQ(read_text(output() + "/mesh.ply"), mesh);
}

// ---- The camera ----

TEST_F(BadInput, IntrinsicsThatAreNotNumbers) {
  write_text(sequence() + "/camera-intrinsics.txt", "nan 0 79.5\n0 131 59.5\n0 0 1\n");
  expect_error(run(), 1, {"camera-intrinsics.txt"});
  expect_error(run({"--intrinsics", "nan,131,79.5,59.5"}), 2, {"--intrinsics", "fx,fy,cx,cy"});
  expect_error(run({"--intrinsics", "131,131,79.5"}), 2, {"--intrinsics", "4 numbers"});
}

TEST_F(BadInput, IntrinsicsOfAnotherImageSize) {
  expect_error(run({"--intrinsics", "525,525,319.5,239.5"}), 1, {"images of another size"});
  expect_error(run({"--camera", "fr7"}), 1, {"fr7", "fr1"});
}

// ---- The command line and the configuration ----

TEST_F(BadInput, UnknownParameter) {
  expect_error(run({"--set", "tracking.normal_gte=3"}), 2, {"'tracking.normal_gte'", "'tracking.normal_gate'"});
  write_text(path("my.toml"), "[volume]\nresolutoin = 64\n");
  expect_error(run({"--config", path("my.toml")}), 1, {"my.toml:2", "'volume.resolution'"});
  expect_error(run({"--config", path("none.toml")}), 1, {"none.toml"});
}

TEST_F(BadInput, ParametersThatContradictEachOther) {
  expect_error(run({"--set", "volume.side=100"}), 1, {"volume.truncation", "voxel"});
  expect_error(run({"--set", "preprocess.max_depth=0.1"}), 1, {"preprocess.min_depth"});
  EXPECT_FALSE(fs::exists(output()));
}

TEST_F(BadInput, UnknownNames) {
  expect_error(run({"--preset", "kinfu"}), 2, {"'kinfu'", "kinectfusion"});
  expect_error(run({"--backend", "abacus"}), 1, {"abacus", "cpu"});
  expect_error(run({"--colour-me", "red"}), 2, {"--colour-me"});
  expect_error(plumbline({"rnu"}), 2, {"--help"});
  expect_error(plumbline({}), 2, {"--help"});
  expect_error(plumbline({"run"}), 2, {"no sequence"});
}

TEST_F(BadInput, ValuesOfTheWrongForm) {
  expect_error(run({"--initial-pose", "1 2 3"}), 2, {"--initial-pose", "7 numbers"});
  expect_error(run({"--initial-pose", "0 0 0 0 0 0 0"}), 2, {"unit length"});
  expect_error(run({"--stride", "0"}), 2, {"--stride"});
  expect_error(run({"--threads", "-1"}), 2, {"--threads"});
  expect_error(run({"--max-frames", "ten"}), 2, {"--max-frames"});
  expect_error(run({"--depth-scale", "0"}), 2, {"--depth-scale"});
}

TEST_F(BadInput, AGroundTruthThatWasNamedMustBeGood) {
  expect_error(run({"--groundtruth", path("none.txt")}), 1, {"none.txt"});
  EXPECT_FALSE(fs::exists(output()));
}

TEST_F(BadInput, TheSequencesOwnBadGroundTruthIsOnlySaid) {
  write_text(sequence() + "/groundtruth.txt", "1 2 3\n1 2 3\n1 2 3\n");
  const Outcome outcome = run({"--no-mesh"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("groundtruth.txt:1"));
  EXPECT_THAT(summary()["ate"]["note"].get<std::string>(), HasSubstr("groundtruth.txt:1"));
}

TEST_F(BadInput, AVolumeThatDoesNotFitInMemory) {
  Launch launch;
  launch.in_child = [] {
    const rlimit limit{std::size_t{3} << 30, std::size_t{3} << 30};
    setrlimit(RLIMIT_AS, &limit);
  };
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "the address sanitizer itself needs more address space than the limit";
#endif
  const Outcome outcome = plumbline(
      {"run", sequence(), "-o", output(), "--set", "volume.resolution=1024", "--set", "volume.side=4"}, launch);
  expect_error(outcome, 1, {"memory", "volume.resolution"});
}

// ---- The output ----

TEST_F(BadInput, AnOutputFolderThatIsAFile) {
  write_text(output(), "mine");
  expect_error(run(), 1, {output()});
  EXPECT_EQ(read_text(output()), "mine");
}

TEST_F(BadInput, AnOutputFolderThatCannotBeMade) {
  write_text(path("file"), "mine");
  expect_error(plumbline(small_run(sequence(), path("file") + "/out")), 1, {path("file")});
  expect_error(plumbline(small_run(sequence(), "/proc/plumbline")), 1, {"/proc/plumbline"});
}

TEST_F(BadInput, AnOutputFolderWithoutPermission) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  fs::create_directory(output());
  fs::permissions(output(), fs::perms::owner_read | fs::perms::owner_exec);
  expect_error(run(), 1, {output()});
  fs::permissions(output(), fs::perms::owner_all);
}

TEST_F(BadInput, AFileSizeLimitLeavesTheOldMeshWhole) {
  const std::string mesh = good_mesh();
  Launch launch;
  launch.in_child = [] {
    const rlimit limit{20000, 20000};  // enough for the lists, not for the mesh
    setrlimit(RLIMIT_FSIZE, &limit);
  };
  expect_error(plumbline(small_run(sequence(), output()), launch), 1, {"mesh.ply"});
  EXPECT_EQ(read_text(output() + "/mesh.ply"), mesh);
  EXPECT_FALSE(fs::exists(output() + "/mesh.ply.partial"));
}

TEST_F(BadInput, AFullDiskLeavesTheOldFilesWhole) {
  const test::SmallDisk disk(output(), "size=3m");
  if (!disk.mounted()) GTEST_SKIP() << "no permission to mount a tmpfs";
  const std::string mesh = good_mesh();
  ASSERT_FALSE(mesh.empty());
  {  // another program fills the disk
    std::ofstream filler(output() + "/filler", std::ios::binary);
    const std::string block(4096, 'x');
    for (int i = 0; i < 2000 && filler.flush(); ++i) filler << block;
  }
  expect_error(run(), 1, {"space"});
  EXPECT_EQ(read_text(output() + "/mesh.ply"), mesh);
  EXPECT_EQ(read_tum_trajectory(output() + "/trajectory.txt").size(), static_cast<std::size_t>(kSmallFrames));
  EXPECT_EQ(summary()["frames"], kSmallFrames);
}

TEST_F(BadInput, AFullDiskBehindStandardOutput) {
  Launch launch;
  launch.stdout_path = "/dev/full";
  expect_error(plumbline({"run", "--print-config"}, launch), 1, {"standard output", "space"});
  expect_error(plumbline({"info", sequence()}, launch), 1, {"standard output"});
}

}  // namespace
}  // namespace plumbline::test
