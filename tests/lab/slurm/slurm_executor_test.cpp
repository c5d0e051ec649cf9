// Runs as a Slurm job array, on the Slurm of one node that with_slurm.sh has started.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "lab/child_process.h"
#include "lab/executor.h"
#include "lab/run_list.h"
#include "plumbline/error.h"
#include "support/program.h"
#include "support/small_sequence.h"

namespace plumbline::test {
namespace {

namespace fs = std::filesystem;
using Job = app::Run;  // testing::Test has a Run of its own
using app::RunOutcome;
using app::RunStatus;
using testing::HasSubstr;

/// `fake DEED FOLDER`: notes each attempt in FOLDER/attempts.
constexpr const char* kFake = R"(#!/bin/sh
echo "$SLURM_ARRAY_TASK_ID" >> "$2/attempts"
attempt=$(wc -l < "$2/attempts")
case $1 in
  good) ;;
  bad) echo "plumbline: error: it rains" >&2; exit 1 ;;
  dies) kill -KILL $$ ;;
  dies-once) [ "$attempt" -gt 1 ] || kill -KILL $$ ;;
  node-lost-once) [ "$attempt" -gt 1 ] || kill -KILL $PPID ;;
  long) sleep 60 ;;
esac
)";

class Slurm : public SmallSequence {
 protected:
  Slurm() {
    write_text(path("fake"), kFake);
    chmod(path("fake").c_str(), 0755);
    options_.folder = path("slurm");
    options_.poll_seconds = 0.2;
    options_.task_program = PLUMBLINE_PROGRAM;
  }
  static void SetUpTestSuite() {
    if (std::getenv("SLURM_CONF") == nullptr) FAIL() << "run by with_slurm.sh";
  }

  Job run(const std::string& name, const std::string& deed) const { return {name, path(name), {deed, path(name)}, {}}; }
  std::map<std::string, RunOutcome> execute(const std::vector<Job>& runs, app::RunWatch watch = {}) {
    std::map<std::string, RunOutcome> told;
    watch.ended = [&](const Job& ended, const RunOutcome& outcome) {
      EXPECT_FALSE(told.contains(ended.name)) << ended.name << " was told twice";
      told[ended.name] = outcome;
    };
    app::make_slurm_executor(options_)->execute(path("fake"), runs, watch);
    return told;
  }
  long attempts(const std::string& name) const {
    const std::string text = read_text(path(name + "/attempts"));
    return std::count(text.begin(), text.end(), '\n');
  }

  app::SlurmOptions options_;
};

std::string queue() { return app::capture({"squeue", "--noheader"}).out; }

TEST_F(Slurm, SubmitsAgainWhatWasBrokenOffAndNothingElse) {
  const auto told = execute({run("a", "good"), run("b", "bad"), run("c", "dies-once"), run("d", "node-lost-once")});
  EXPECT_EQ(told.at("a").status, RunStatus::finished);
  EXPECT_EQ(attempts("a"), 1);
  EXPECT_EQ(told.at("b").status, RunStatus::failed);  // the same would come of it
  EXPECT_EQ(told.at("b").error, "it rains");
  EXPECT_EQ(attempts("b"), 1);
  EXPECT_EQ(told.at("c").status, RunStatus::finished);
  EXPECT_EQ(attempts("c"), 2);
  EXPECT_EQ(told.at("d").status, RunStatus::finished);
  EXPECT_EQ(attempts("d"), 2);
  EXPECT_EQ(queue(), "");
}

TEST_F(Slurm, GivesUpAfterTheRetries) {
  options_.retries = 1;
  const auto told = execute({run("a", "good"), run("b", "dies")});
  EXPECT_EQ(told.at("a").status, RunStatus::finished);
  EXPECT_EQ(told.at("b").status, RunStatus::killed);
  EXPECT_THAT(told.at("b").error, HasSubstr("signal 9"));
  EXPECT_EQ(attempts("b"), 2);
}

TEST_F(Slurm, AnInterruptionCancelsTheJob) {
  app::RunWatch watch;
  bool interrupted = false;
  watch.interrupted = [&] {
    interrupted = interrupted || fs::exists(path("a/attempts"));
    return interrupted;
  };
  EXPECT_TRUE(execute({run("a", "long"), run("b", "long")}, watch).empty());
  for (int i = 0; i < 200 && !queue().empty(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(queue(), "");
}

TEST_F(Slurm, WaitsForTheJobsOfACallThatWasLost) {
  write_text(path("sleeper.sh"), "#!/bin/sh\nsleep 3\ntouch " + path("slept") + "\n");
  const app::Captured sleeper = app::capture({"sbatch", "--parsable", "--output=/dev/null", path("sleeper.sh")});
  ASSERT_EQ(sleeper.exit_code, 0) << sleeper.err;
  fs::create_directories(options_.folder);
  write_text(options_.folder + "/jobs.txt", sleeper.out);
  std::string notes;
  app::RunWatch watch;
  watch.note = [&](const std::string& note) { notes += note; };
  const auto told = execute({run("a", "good")}, watch);
  EXPECT_TRUE(fs::exists(path("slept")));
  EXPECT_THAT(notes, HasSubstr("earlier call"));
  EXPECT_EQ(told.at("a").status, RunStatus::finished);
  EXPECT_FALSE(fs::exists(options_.folder + "/jobs.txt"));
}

TEST_F(Slurm, TellsWhatSbatchRefuses) {
  options_.options = {"--partition=nowhere"};
  try {
    execute({run("a", "good")});
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("partition"));
  }
}

/// Both executors with the program itself: the same bytes, the same table.
TEST_F(Slurm, BatchGivesTheSameAsLocally) {
  fs::create_directory(path("nothing"));
  const auto batch = [&](const std::string& executor) {
    const std::vector<std::string> words = {"batch",
                                            sequence(),
                                            path("nothing"),
                                            "-o",
                                            path(executor),
                                            "--executor",
                                            executor,
                                            "--preset",
                                            "plumbline,kinectfusion",
                                            "--orientation",
                                            "none,groundtruth.txt",
                                            "--set",
                                            "volume.resolution=96",
                                            "--set",
                                            "volume.side=4",
                                            "--set",
                                            "volume.offset=0",
                                            "--set",
                                            "volume.truncation=0.1"};
    return plumbline(words);
  };
  const Outcome local = batch("local"), slurm = batch("slurm");
  EXPECT_EQ(local.exit_code, 1);
  EXPECT_EQ(slurm.exit_code, 1);
  EXPECT_THAT(slurm.out, HasSubstr("4 of 8 runs are finished"));
  for (const char* name :
       {"desk-plumbline", "desk-kinectfusion", "desk-plumbline-groundtruth", "desk-kinectfusion-groundtruth"})
    for (const char* file : {"trajectory.txt", "mesh.ply", "config.toml"}) {
      const std::string bytes = read_text(path("local") + "/" + name + "/" + file);
      EXPECT_FALSE(bytes.empty()) << name << file;
      EXPECT_EQ(bytes, read_text(path("slurm") + "/" + name + "/" + file)) << name << file;
    }
  auto one = nlohmann::json::parse(read_text(path("local/batch.json"))),
       other = nlohmann::json::parse(read_text(path("slurm/batch.json")));
  ASSERT_EQ(one.size(), 8U);
  for (auto* table : {&one, &other})
    for (auto& row : *table) row.erase("ms a frame");
  EXPECT_EQ(one, other);
}

TEST_F(Slurm, ReproduceGivesTheSameAsLocally) {
  fs::create_directories(path("data/tum"));
  fs::rename(sequence(), path("data/tum/rgbd_dataset_freiburg1_xyz"));
  for (const std::string executor : {"local", "slurm"}) {
    const Outcome outcome = plumbline({"reproduce", "ate", "--data", path("data"), "-o", path(executor), "--executor",
                                       executor, "--frames", "3", "--seeds", "1"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  }
  const std::string table = read_text(path("local/ate.csv"));
  EXPECT_THAT(table, HasSubstr("fr1/xyz,0"));
  EXPECT_EQ(table, read_text(path("slurm/ate.csv")));
}

}  // namespace
}  // namespace plumbline::test
