#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "cli/console.h"
#include "io/atomic_file.h"
#include "lab/executor.h"
#include "lab/reproduce.h"
#include "plumbline/error.h"

namespace plumbline::app {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxPrinted = 60;  // rows of a table on the terminal

struct Item {
  const char* name;
  Plan (*plan)(const ReproduceOptions&);
};
constexpr Item kItems[] = {{"angles", plan_angles},         {"lambda", plan_lambda}, {"timing", plan_timing},
                           {"iterations", plan_iterations}, {"ate", plan_ate},       {"uncertainty", plan_uncertainty}};

struct ReproduceArguments {
  std::vector<std::string> what;
  ReproduceOptions options;
  ExecutorArguments executor;
  bool reduced = false;
};

std::vector<Plan> plans_of(const ReproduceArguments& arguments, const ReproduceOptions& options) {
  std::vector<Plan> plans;
  for (const Item& item : kItems) {
    const auto& what = arguments.what;
    const auto given = [&](const char* name) { return std::find(what.begin(), what.end(), name) != what.end(); };
    if (given(item.name) || given("all")) plans.push_back(item.plan(options));
  }
  return plans;
}

/// Of all plans, each once: tables share runs.
std::vector<Run> together(const std::vector<Plan>& plans, std::vector<Run> Plan::*list) {
  std::vector<Run> all;
  std::set<std::string> folders;
  for (const Plan& plan : plans)
    for (const Run& run : plan.*list)
      if (folders.insert(run.folder).second) all.push_back(run);
  return all;
}

/// Names what is missing; counts it.
class Work {
 public:
  explicit Work(const ReproduceArguments& arguments) : arguments_(arguments) {}

  /// Whether to go on.
  bool carry_out(const std::vector<Run>& runs, const char* what, int jobs) {
    if (runs.empty()) return true;
    const auto executor =
        make_executor(arguments_.executor, (fs::path(arguments_.options.output) / "slurm").string(), jobs);
    const Outcomes outcomes = app::carry_out(runs, *executor, what, arguments_.executor.quiet);
    signal_ = outcomes.signal;
    for (std::size_t i = 0; i < runs.size(); ++i)
      if (outcomes.runs[i].status != RunStatus::finished)
        failed_.push_back(runs[i].name + ": " + outcomes.runs[i].error);
    return signal_ == 0;
  }

  int signal() const { return signal_; }
  const std::vector<std::string>& failed() const { return failed_; }

 private:
  const ReproduceArguments& arguments_;
  int signal_ = 0;
  std::vector<std::string> failed_;
};

void write_result(const ReproduceResult& result, const fs::path& folder, std::string* document) {
  for (const Table& table : result.tables) {
    write_file((folder / (table.name + ".csv")).string(), table_csv(table));
    write_file((folder / (table.name + ".md")).string(), table_markdown(table));
    if (table.rows.size() > kMaxPrinted) continue;
    *document += table_markdown(table) + "\n";
    say("\n{}\n\n{}", table.title, table_text(table));
    for (const std::string& note : table.notes) say("{}", note);
  }
  for (const auto& [name, plot] : result.plots) save_plot(plot, (folder / (name + ".svg")).string());
}

int reproduce(const ReproduceArguments& arguments) {
  ReproduceOptions options = arguments.options;
  options.incidental = incidental_arguments(arguments.executor);
  const fs::path folder(options.output);
  ensure_directory(options.output);
  check_plot((folder / "plot.svg").string());
  const std::vector<Plan> plans = plans_of(arguments, options);
  Work work(arguments);
  if (!work.carry_out(together(plans, &Plan::sequences), "sequence", 0) ||
      !work.carry_out(together(plans, &Plan::runs), "run", 0) ||
      !work.carry_out(together(plans, &Plan::timed), "timed run", 1)) {
    say("interrupted; the same command goes on");
    return 128 + work.signal();
  }
  std::string document;
  for (const Plan& plan : plans) write_result(plan.result(), folder, &document);
  write_file((folder / "reproduce.md").string(), document);
  say("\nthe tables and figures are in {}", options.output);
  flush_output();
  if (work.failed().empty()) return 0;
  complain(
      fmt::format("{} runs are missing in the tables:\n  {}", work.failed().size(), fmt::join(work.failed(), "\n  ")));
  return kExitError;
}

std::string default_data() {
  const char* data = std::getenv("PLUMBLINE_DATA");
  return data == nullptr ? "" : data;
}

void add_options(CLI::App& command, ReproduceArguments& a) {
  std::vector<std::string> names = {"all"};
  for (const Item& item : kItems) names.emplace_back(item.name);
  command.add_option("what", a.what, "angles, lambda, timing, iterations, ate, uncertainty, or all")
      ->required()
      ->check(CLI::IsMember(names))
      ->type_name("NAME");
  command
      .add_option(
          "--data", a.options.data,
          "Folder with recordings (rgbd_dataset_freiburg1_xyz, …) and paths (trajectories/groundtruth); default: "
          "$PLUMBLINE_DATA")
      ->type_name("DIR");
  command.add_option("-o,--output", a.options.output, "Folder of sequences, runs, tables and figures")
      ->capture_default_str()
      ->type_name("DIR");
}

/// How much is done; what is given counts even with --reduced.
void add_sizes(CLI::App& command, ReproduceOptions& o) {
  const auto list = [&](const char* name, auto& values, const char* help, const char* type) {
    return command.add_option(name, values, help)
        ->delimiter(',')
        ->capture_default_str()
        ->type_name(type)
        ->allow_extra_args(false);
  };
  std::vector<std::string> names;
  for (const PaperDataset& dataset : paper_datasets()) names.emplace_back(dataset.name);
  list("--datasets", o.datasets, "Of the paper's (default: all)", "NAME,…")->check(CLI::IsMember(names));
  list("--scenes", o.scenes, "Simulated ones, for pairs of frames and for paths without a recording", "NAME,…");
  list("--speeds", o.speeds, "At which paths go through them", "X,…")->check(CLI::Range(0.01, 100.0));
  list("--strides", o.strides, "Of the table of ATE: every Nth frame", "N,…")->check(CLI::Range(1, 1000));
  list("--angles", o.angles, "Degrees", "DEG,…")->check(CLI::Range(0.1, 180.0));
  command.add_option("--turn-axis", o.turn_axis, "Of pairs: pan (left or right), or any across the line of sight")
      ->check(CLI::IsMember({"pan", "any"}))
      ->capture_default_str()
      ->type_name("NAME");
  list("--sensors", o.sensors, "Of the table of λ: ideal, bno055", "NAME,…")->check(CLI::IsMember({"ideal", "bno055"}));
  const auto number = [&](const char* name, int& value, const char* help, int lowest) {
    command.add_option(name, value, help)->check(CLI::Range(lowest, 1'000'000))->capture_default_str()->type_name("N");
  };
  number("--frames", o.frames, "The first so many of each sequence, 0 for all", 0);
  number("--timed-frames", o.timed_frames, "Same, for the tables of times", 0);
  number("--seeds", o.seeds, "Seeds 1 to N of the sensor's error", 1);
  number("--pairs", o.pairs, "Of frames, for each scene and angle", 1);
}

/// What was given by itself stays.
void reduce(const CLI::App& command, ReproduceOptions* options) {
  const ReproduceOptions given = *options;
  *options = reduced(given);
  const auto keep = [&](const char* name, auto ReproduceOptions::*member) {
    if (command.count(name) > 0) options->*member = given.*member;
  };
  keep("--datasets", &ReproduceOptions::datasets);
  keep("--scenes", &ReproduceOptions::scenes);
  keep("--speeds", &ReproduceOptions::speeds);
  keep("--angles", &ReproduceOptions::angles);
  keep("--sensors", &ReproduceOptions::sensors);
  keep("--frames", &ReproduceOptions::frames);
  keep("--timed-frames", &ReproduceOptions::timed_frames);
  keep("--seeds", &ReproduceOptions::seeds);
  keep("--pairs", &ReproduceOptions::pairs);
}

}  // namespace

void add_reproduce_command(CLI::App& app, Command& chosen) {
  const auto arguments = std::make_shared<ReproduceArguments>();
  arguments->options.output = "reproduce";
  arguments->options.data = default_data();
  CLI::App* command =
      app.add_subcommand("reproduce", "Make the paper's tables and figures, the paper's numbers beside ours");
  add_options(*command, *arguments);
  command->add_flag("--reduced", arguments->reduced,
                    "Fewer datasets, frames and seeds: a quarter of an hour on two processors");
  add_sizes(*command, arguments->options);
  add_executor_arguments(*command, arguments->executor);
  command->footer(
      "Runs are kept and shared between the tables; the same command goes on where it was broken off. Each table is\n"
      "written as NAME.md and NAME.csv, each figure as NAME.svg, and all tables as reproduce.md.");
  command->callback([arguments, command, &chosen] {
    if (arguments->reduced) reduce(*command, &arguments->options);
    chosen = [arguments] { return reproduce(*arguments); };
  });
}

}  // namespace plumbline::app
