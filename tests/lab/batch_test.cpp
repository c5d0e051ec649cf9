// Lists of runs: records, the pool, grids, and `batch` as a user calls it. What is run is mostly a shell script that
// does as its first argument says.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "cli/arguments.h"
#include "lab/child_process.h"
#include "lab/executor.h"
#include "lab/run_grid.h"
#include "lab/run_list.h"
#include "run/run_figures.h"
#include "support/program.h"
#include "support/small_sequence.h"
#include "support/terminal.h"

namespace plumbline::test {
namespace {

namespace fs = std::filesystem;
using app::Outcomes;
using Job = app::Run;  // testing::Test has a Run of its own
using app::RunOutcome;
using app::RunStatus;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

/// `fake DEED FOLDER …`: notes its start and end in FOLDER/../trace.
constexpr const char* kFake = R"(#!/bin/sh
echo "+ $1" >> "$2/../trace"
case $1 in
  good) sleep 0.2; echo fine > "$2/result" ;;
  bad) echo "working"; echo "plumbline: error: it rains" >&2; echo "  Take an umbrella." >&2; exit 1 ;;
  silent) exit 3 ;;
  killed) kill -KILL $$ ;;
  long) trap 'echo "i $1" >> "$2/../trace"; kill $!; exit 130' INT; sleep 30 & wait ;;
esac
echo "- $1" >> "$2/../trace"
)";

class Pool : public testing::Test {
 protected:
  Pool() {
    program_ = (folder_ / "fake").string();
    write_text(program_, kFake);
    chmod(program_.c_str(), 0755);
  }

  Job run(const std::string& name, const std::string& deed) const {
    const std::string folder = (folder_ / name).string();
    return {name, folder, {deed, folder}, {}};
  }

  /// All of them, with the local executor.
  std::vector<RunOutcome> execute(const std::vector<Job>& runs, int jobs = 2, const app::RunWatch& watch = {}) const {
    app::make_local_executor(jobs)->execute(program_, runs, watch);
    std::vector<RunOutcome> outcomes;
    for (const Job& run : runs) outcomes.push_back(app::outcome_of(run));
    return outcomes;
  }

  std::string trace() const { return read_text((folder_ / "trace").string()); }

  test::TempFolder temp_;
  fs::path folder_ = temp_.path();
  std::string program_;
};

TEST_F(Pool, KeepsGoingWhereOneFailsAndSaysWhy) {
  const auto outcomes =
      execute({run("a", "good"), run("b", "bad"), run("c", "silent"), run("d", "killed"), run("e", "good")});
  EXPECT_EQ(outcomes[0].status, RunStatus::finished);
  EXPECT_GE(outcomes[0].seconds, 0.2);
  EXPECT_EQ(outcomes[1].status, RunStatus::failed);
  EXPECT_EQ(outcomes[1].error, "it rains\n  Take an umbrella.");
  EXPECT_EQ(outcomes[2].status, RunStatus::failed);
  EXPECT_EQ(outcomes[2].error, "exit code 3");
  EXPECT_EQ(outcomes[3].status, RunStatus::killed);
  EXPECT_THAT(outcomes[3].error, HasSubstr("signal 9"));
  EXPECT_EQ(outcomes[4].status, RunStatus::finished);
  EXPECT_EQ(read_text((folder_ / "b" / "log.txt").string()),
            "working\nplumbline: error: it rains\n  Take an umbrella.\n");
}

TEST_F(Pool, RunsSoManyAtATime) {
  std::vector<Job> runs;
  for (int i = 0; i < 5; ++i) runs.push_back(run(std::to_string(i), "good"));
  execute(runs, 2);
  int now = 0, most = 0;
  for (const char c : trace()) {
    now += (c == '+') - (c == '-');
    most = std::max(most, now);
  }
  EXPECT_EQ(now, 0);
  EXPECT_EQ(most, 2);
}

TEST_F(Pool, ARunThatCannotStartKeepsNoOther) {
  write_text((folder_ / "file").string(), "");
  Job blocked = run("x", "good");
  blocked.folder = (folder_ / "file").string();
  std::string error;
  app::RunWatch watch;
  watch.ended = [&](const Job& ended, const RunOutcome& outcome) {
    if (ended.name == "x") error = outcome.error;
  };
  const auto outcomes = execute({blocked, run("a", "good")}, 1, watch);
  EXPECT_THAT(error, HasSubstr("file"));
  EXPECT_EQ(outcomes[1].status, RunStatus::finished);
}

TEST_F(Pool, AnInterruptionReachesTheChildrenAndLeavesNoRecord) {
  const std::vector<Job> runs = {run("a", "long"), run("b", "good")};
  bool interrupted = false;
  app::RunWatch watch;
  watch.interrupted = [&] {
    interrupted = interrupted || trace().find("+ long") != std::string::npos;
    return interrupted;
  };
  const auto begin = std::chrono::steady_clock::now();
  const auto outcomes = execute(runs, 1, watch);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
  EXPECT_EQ(trace(), "+ long\ni long\n");  // and the second was not begun
  EXPECT_EQ(outcomes[0].status, RunStatus::none);
  EXPECT_EQ(outcomes[1].status, RunStatus::none);
}

TEST_F(Pool, ARecordIsOfItsArguments) {
  Job a = run("a", "good");
  execute({a});
  EXPECT_EQ(app::outcome_of(a).status, RunStatus::finished);
  a.incidental = {"--threads", "7"};
  EXPECT_EQ(app::outcome_of(a).status, RunStatus::finished);
  a.arguments.emplace_back("--set");
  EXPECT_EQ(app::outcome_of(a).status, RunStatus::foreign);
  EXPECT_THAT(app::outcome_of(a).error, HasSubstr("good"));

  Job b = run("b", "bad");  // what failed is in nobody's way
  execute({b});
  b.arguments.emplace_back("--set");
  EXPECT_EQ(app::outcome_of(b).status, RunStatus::none);

  Job c = run("c", "good");
  c.arguments.push_back("a name that is not UTF-8: \xff");
  execute({c});
  EXPECT_EQ(app::outcome_of(c).status, RunStatus::finished);
}

TEST_F(Pool, AHalfWrittenRecordIsNone) {
  const Job a = run("a", "good");
  execute({a});
  const std::string record = (folder_ / "a" / "run.json").string(), text = read_text(record);
  write_text(record, text.substr(0, text.size() / 2));
  EXPECT_EQ(app::outcome_of(a).status, RunStatus::none);
  write_text(record, "[]");
  EXPECT_EQ(app::outcome_of(a).status, RunStatus::none);
}

TEST_F(Pool, AListComesBackFromJson) {
  Job a = run("a", "good");
  a.incidental = {"--quiet"};
  const app::RunList list = app::parse_run_list(app::run_list_json("/bin/program", {a}), "here");
  EXPECT_EQ(list.program, "/bin/program");
  ASSERT_EQ(list.runs.size(), 1U);
  EXPECT_EQ(list.runs[0].name, a.name);
  EXPECT_EQ(list.runs[0].folder, a.folder);
  EXPECT_EQ(list.runs[0].arguments, a.arguments);
  EXPECT_EQ(list.runs[0].incidental, a.incidental);
  EXPECT_THROW(app::parse_run_list("{}", "here"), Error);
  EXPECT_THROW(app::parse_run_list("no json", "here"), Error);
}

TEST_F(Pool, TaskCarriesOutOneOfAList) {
  const std::string list = (folder_ / "list.json").string();
  const Job a = run("a", "good"), b = run("b", "bad");
  write_text(list, app::run_list_json(program_, {a, b}));
  EXPECT_EQ(plumbline({"task", list, "1"}).exit_code, 1);
  EXPECT_EQ(app::outcome_of(a).status, RunStatus::none);
  EXPECT_EQ(app::outcome_of(b).error, "it rains\n  Take an umbrella.");
  EXPECT_EQ(plumbline({"task", list, "0"}).exit_code, 0);
  EXPECT_EQ(app::outcome_of(a).status, RunStatus::finished);
  EXPECT_THAT(plumbline({"task", list, "2"}).err, HasSubstr("no such run"));
}

/// Counts what it is asked for and does it itself.
class CountingExecutor : public app::Executor {
 public:
  void execute(const std::string&, const std::vector<Job>& runs, const app::RunWatch& watch) override {
    asked += static_cast<int>(runs.size());
    for (const Job& run : runs) {
      app::begin_record(run);
      watch.ended(run, app::write_record(run, run.name == "bad" ? 1 << 8 : 0, 1));
    }
  }
  int asked = 0;
};

TEST_F(Pool, WhatIsFinishedIsKeptAndWhatFailedIsTriedAgain) {
  CountingExecutor executor;
  std::vector<Job> runs = {run("good", "x"), run("bad", "x")};
  Outcomes outcomes = app::carry_out(runs, executor, "run", true);
  EXPECT_EQ(executor.asked, 2);
  EXPECT_EQ(outcomes.kept, 0);
  EXPECT_FALSE(outcomes.all_finished());
  runs.push_back(run("more", "x"));
  outcomes = app::carry_out(runs, executor, "run", true);
  EXPECT_EQ(executor.asked, 4);
  EXPECT_EQ(outcomes.kept, 1);
  EXPECT_EQ(outcomes.count(RunStatus::finished), 2);
  EXPECT_EQ(outcomes.count(RunStatus::failed), 1);
}

TEST_F(Pool, TwoRunsMayNotShareAFolder) {
  CountingExecutor executor;
  EXPECT_THROW(app::carry_out({run("a", "x"), run("a", "y")}, executor, "run", true), Error);
}

TEST(Capture, GivesOutputErrorsAndExitCode) {
  const app::Captured done = app::capture({"sh", "-c", "echo out; echo err >&2; exit 4"});
  EXPECT_EQ(done.exit_code, 4);
  EXPECT_EQ(done.out, "out\n");
  EXPECT_EQ(done.err, "err\n");
  EXPECT_EQ(app::capture({"there-is-no-such-program"}).exit_code, 127);
}

// ---- grids

std::vector<std::string> names(const std::vector<Job>& runs) {
  std::vector<std::string> list;
  for (const Job& run : runs) list.push_back(run.name);
  return list;
}

TEST(Grid, IsEveryValueWithEveryOther) {
  app::Grid grid;
  grid.sequences = {"/data/one/", "/data/two"};
  grid.presets = {"plumbline", "paper"};
  grid.orientations = {"none", "chip.txt"};
  grid.imu_models = {"ideal", "bno055"};
  grid.seeds = 2;
  const std::vector<Job> runs = app::runs_of(grid, "/out");
  ASSERT_EQ(runs.size(), 2U * 2U * 4U);  // none, ideal, two seeds
  EXPECT_EQ(runs[0].name, "one-plumbline");
  EXPECT_EQ(runs[0].folder, "/out/one-plumbline");
  EXPECT_THAT(runs[0].arguments, ElementsAre("run", "/data/one", "-o", "/out/one-plumbline", "--preset", "plumbline",
                                             "--orientation", "none"));
  EXPECT_EQ(runs.back().name, "two-paper-chip-bno055-seed2");
  EXPECT_THAT(app::command_text(runs.back().arguments),
              HasSubstr("--orientation /data/two/chip.txt --orientation-max-gap 0.5 --imu-model bno055 --imu-seed 2"));
}

TEST(Grid, KeepsNamesWhenItGrows) {
  app::Grid grid;
  grid.sequences = {"/data/one"};
  const std::vector<std::string> before = names(app::runs_of(grid, "/out"));
  grid.presets.push_back("paper");
  grid.strides = {1, 3};
  grid.orientations.push_back("chip.txt");
  const std::vector<std::string> after = names(app::runs_of(grid, "/out"));
  EXPECT_THAT(after, testing::Contains(before.at(0)));
  EXPECT_THAT(after, testing::Contains("one-paper-chip-stride3"));
}

TEST(Grid, VariesParametersWhoseValuesMayBeLists) {
  EXPECT_THAT(app::split_values("1,[2,3],x"), ElementsAre("1", "[2,3]", "x"));
  app::Grid grid;
  grid.sequences = {"/data/one"};
  grid.variations = {app::parse_variation("tracking.iterations=[4,5,10],[2,2,3]")};
  EXPECT_THAT(names(app::runs_of(grid, "/out")),
              ElementsAre("one-plumbline-tracking.iterations=_4,5,10_", "one-plumbline-tracking.iterations=_2,2,3_"));
  EXPECT_THROW(app::parse_variation("volume.side"), app::UsageError);
  EXPECT_THROW(app::parse_variation("=3"), app::UsageError);
}

TEST(Grid, RefusesWhatIsNoValueBeforeAnythingRuns) {
  app::Grid grid;
  grid.sequences = {"/data/one"};
  grid.presets = {"best"};
  EXPECT_THROW(app::runs_of(grid, "/out"), app::UsageError);
  grid.presets = {"paper", "paper"};
  EXPECT_THROW(app::runs_of(grid, "/out"), app::UsageError);
  grid.presets = {"paper"};
  grid.variations = {{"volume.sid", {"3"}}};
  EXPECT_THROW(app::runs_of(grid, "/out"), app::UsageError);
}

TEST(Grid, TellsSequencesOfOneNameApart) {
  EXPECT_THAT(app::sequence_names({"/a/chess/seq-01", "/a/fire/seq-01/", "/a/fire/seq-02"}),
              ElementsAre("chess_seq-01", "fire_seq-01", "fire_seq-02"));
  EXPECT_THAT(app::sequence_names({"/a/chess", "/b/fire"}), ElementsAre("chess", "fire"));
}

// ---- the command

class Batch : public SmallSequence {
 protected:
  std::vector<std::string> command(const std::vector<std::string>& more) const {
    std::vector<std::string> words = {"batch",  "-o",
                                      output(), "--no-mesh",
                                      "--set",  "volume.resolution=96",
                                      "--set",  "volume.side=4",
                                      "--set",  "volume.offset=0",
                                      "--set",  "volume.truncation=0.1"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  std::string in_output(const std::string& name) const { return output() + "/" + name; }
};

TEST_F(Batch, DoesWhatSingleRunsDo) {
  const Outcome batch = plumbline(command({sequence(), "--preset", "plumbline,kinectfusion", "--stride", "1,2"}));
  ASSERT_EQ(batch.exit_code, 0) << batch.err;
  ASSERT_EQ(plumbline(small_run(sequence(), path("alone"), {"--no-mesh", "--preset", "kinectfusion", "--stride", "2"}))
                .exit_code,
            0);
  EXPECT_EQ(read_text(in_output("desk-kinectfusion-stride2/trajectory.txt")),
            read_text(path("alone") + "/trajectory.txt"));

  const auto alone = nlohmann::json::parse(read_text(path("alone") + "/summary.json"));
  const auto table = nlohmann::json::parse(read_text(in_output("batch.json")));
  ASSERT_EQ(table.size(), 4U);
  EXPECT_EQ(table[3]["run"], "desk-kinectfusion-stride2");
  EXPECT_EQ(table[3]["status"], "finished");
  EXPECT_EQ(table[3]["frames"], 5);
  EXPECT_DOUBLE_EQ(table[3]["ATE RMSE (m)"].get<double>(), alone["ate"]["rmse_m"].get<double>());
  EXPECT_NEAR(table[3]["ATE all frames (m)"].get<double>(), alone["ate"]["rmse_m"].get<double>(),
              1e-6);  // none is lost
  EXPECT_THAT(batch.out, HasSubstr("4 of 4 runs are finished"));
  EXPECT_THAT(read_text(in_output("batch.md")), HasSubstr("| desk-plumbline | finished | 10 | 0 |"));
}

TEST_F(Batch, NamesWhatFailsAndGoesOnWithTheRest) {
  fs::create_directory(path("nothing"));
  const Outcome first = plumbline(command({path("nothing"), sequence()}));
  EXPECT_EQ(first.exit_code, 1);
  EXPECT_THAT(first.err, HasSubstr("nothing-plumbline: " + path("nothing") + ": the folder holds no sequence"));
  EXPECT_THAT(first.out, HasSubstr("1 of 2 runs are finished"));
  const auto written = fs::last_write_time(in_output("desk-plumbline/trajectory.txt"));

  // Once it is there, the same command makes what was missing, and nothing else.
  fs::copy(sequence(), path("nothing"), fs::copy_options::recursive);
  const Outcome second = plumbline(command({path("nothing"), sequence()}));
  EXPECT_EQ(second.exit_code, 0) << second.err;
  EXPECT_THAT(second.out, HasSubstr("1 of 2 runs are finished already"));
  EXPECT_EQ(fs::last_write_time(in_output("desk-plumbline/trajectory.txt")), written);
  EXPECT_EQ(read_text(in_output("nothing-plumbline/trajectory.txt")),
            read_text(in_output("desk-plumbline/trajectory.txt")));
}

TEST_F(Batch, LeavesTheRunsOfAnotherCommandAlone) {
  ASSERT_EQ(plumbline(command({sequence()})).exit_code, 0);
  const std::string before = read_text(in_output("desk-plumbline/trajectory.txt"));
  const Outcome other = plumbline(command({sequence(), "--max-frames", "3"}));
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_THAT(other.err, HasSubstr("another command"));
  EXPECT_EQ(read_text(in_output("desk-plumbline/trajectory.txt")), before);
}

TEST_F(Batch, CtrlCStopsAndTheNextCallGoesOn) {
  const std::vector<std::string> words = command(
      {sequence(), "--jobs", "1", "--vary", "volume.max_weight=20,30,40,50,60,70,80,90", "--preset", "kinectfusion"});
  const std::string first = in_output("desk-kinectfusion-volume.max_weight=20/run.json");
  Running running(words);
  for (int i = 0; i < 3000 && !fs::exists(first); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  ASSERT_TRUE(fs::exists(first));
  kill(running.pid(), SIGINT);
  const Outcome stopped = running.wait();
  EXPECT_EQ(stopped.exit_code, 130);
  EXPECT_THAT(stopped.out, HasSubstr("the same command goes on"));
  EXPECT_FALSE(fs::exists(in_output("desk-kinectfusion-volume.max_weight=90/run.json")));
  const auto written = fs::last_write_time(first);

  const Outcome next = plumbline(words);
  EXPECT_EQ(next.exit_code, 0) << next.err;
  EXPECT_THAT(next.out, HasSubstr("8 of 8 runs are finished;"));
  EXPECT_EQ(fs::last_write_time(first), written);
}

TEST_F(Batch, ShowsABarOnATerminal) {
  PLUMBLINE_TERMINAL_OR_SKIP();
  const Outcome outcome = plumbline_on_terminal(command({sequence(), "--preset", "plumbline,paper"}));
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.err, testing::AllOf(HasSubstr("\r["), HasSubstr("2/2  2 finished, 0 failed")));
}

TEST_F(Batch, RefusesMistakesOnTheCommandLine) {
  EXPECT_EQ(plumbline({"batch"}).exit_code, 2);
  EXPECT_EQ(plumbline(command({sequence(), "--preset", "best"})).exit_code, 2);
  EXPECT_EQ(plumbline(command({sequence(), "--vary", "volume.side"})).exit_code, 2);
  EXPECT_EQ(plumbline(command({sequence(), "--executor", "cloud"})).exit_code, 2);
  EXPECT_EQ(plumbline(command({sequence(), sequence()})).exit_code, 2);
  EXPECT_FALSE(fs::exists(output()));
}

TEST_F(Batch, PrintsTheCommandsWithoutRunningThem) {
  const Outcome outcome = plumbline(command({sequence(), "--dry-run", "--stride", "1,2"}));
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.out, HasSubstr("run " + sequence() + " -o "));
  EXPECT_EQ(std::count(outcome.out.begin(), outcome.out.end(), '\n'), 2);
  EXPECT_FALSE(fs::exists(output()));
}

TEST_F(Batch, SaysWhereSlurmIsMissing) {
  Launch launch;
  launch.in_child = [] { setenv("PATH", "/nowhere", 1); };
  const Outcome outcome = plumbline(command({sequence(), "--executor", "slurm"}), launch);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, testing::AllOf(HasSubstr("sbatch"), HasSubstr("--executor local")));
}

// ---- figures

TEST_F(Batch, FiguresCountALostFrameWithItsLastPose) {
  const std::string table = path("frames.csv");
  write_text(table, "a,\"b, c\"\r\n1,\"x \"\"y\"\"\"\n2,\"two\nlines\"");
  const app::CsvRows rows(table);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows.text(0, "b, c"), "x \"y\"");
  EXPECT_EQ(rows.text(1, "b, c"), "two\nlines");
  EXPECT_EQ(rows.number(1, "a"), 2);
  EXPECT_THROW(rows.number(0, "b, c"), Error);
  EXPECT_THROW(rows.text(0, "d"), Error);
  write_text(table, "a,b\n1\n");
  EXPECT_THROW(app::CsvRows{table}, Error);
  write_text(table, "");
  EXPECT_THROW(app::CsvRows{table}, Error);

  good_mesh();
  const app::RunFigures figures = app::run_figures(output());
  EXPECT_EQ(figures.frames, kSmallFrames);
  EXPECT_EQ(figures.frame_ms.size(), static_cast<std::size_t>(kSmallFrames));
  ASSERT_TRUE(figures.ate && figures.ate_all);
  // The last frame's row as one that was lost: its pose then is the one before.
  std::string text = read_text(output() + "/frames.csv");
  while (text.back() == '\n') text.pop_back();
  const std::size_t last = text.rfind('\n');
  const auto pose_begin = [&](std::size_t end) {  // of the row that ends there: its last seven fields
    std::size_t comma = end;
    for (int i = 0; i < 7; ++i) comma = text.rfind(',', comma - 1);
    return comma;
  };
  const std::size_t kept = pose_begin(last);
  text = text.substr(0, pose_begin(text.size())) + text.substr(kept, last - kept) + "\n";
  write_text(output() + "/frames.csv", text);
  const app::RunFigures lost = app::run_figures(output());
  EXPECT_EQ(lost.ate, figures.ate);
  EXPECT_GT(*lost.ate_all, 2 * *figures.ate_all);
}

}  // namespace
}  // namespace plumbline::test
