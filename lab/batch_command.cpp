#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "cli/arguments.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/table.h"
#include "io/atomic_file.h"
#include "lab/executor.h"
#include "lab/run_grid.h"
#include "lab/split_words.h"
#include "plumbline/error.h"
#include "run/run_figures.h"

namespace plumbline::app {
namespace {

namespace fs = std::filesystem;

struct BatchArguments {
  Grid grid;
  ExecutorArguments executor;
  std::string output = "batch", config, run_options;
  std::vector<std::string> settings, variations;
  int max_frames = 0;
  bool no_mesh = false, dry_run = false;
};

/// Options that are the same for all runs.
std::vector<std::string> common_arguments(const BatchArguments& arguments) {
  std::vector<std::string> words;
  if (!arguments.config.empty()) words = {"--config", fs::absolute(arguments.config).string()};
  for (const std::string& setting : arguments.settings) words.insert(words.end(), {"--set", setting});
  if (arguments.max_frames > 0) words.insert(words.end(), {"--max-frames", std::to_string(arguments.max_frames)});
  if (arguments.no_mesh) words.emplace_back("--no-mesh");
  const std::vector<std::string> more = split_words(arguments.run_options);
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

std::vector<Run> wanted_runs(const BatchArguments& arguments) {
  Grid grid = arguments.grid;
  for (const std::string& text : arguments.variations) grid.variations.push_back(parse_variation(text));
  grid.arguments = common_arguments(arguments);
  grid.incidental = incidental_arguments(arguments.executor);
  return runs_of(grid, arguments.output);
}

const char* status_text(RunStatus status) {
  switch (status) {
    case RunStatus::finished:
      return "finished";
    case RunStatus::failed:
      return "failed";
    case RunStatus::killed:
      return "killed";
    case RunStatus::foreign:
      return "another run's";
    case RunStatus::none:
      break;
  }
  return "not run";
}

std::vector<Cell> row_of(const Run& run, const RunOutcome& outcome) {
  std::string error = outcome.error;
  if (outcome.status == RunStatus::finished) {
    try {
      const RunFigures f = run_figures(run.folder);
      return {run.name,
              "finished",
              Cell(f.frames, 0),
              Cell(f.lost, 0),
              number_or_dash(f.ate, 4),
              number_or_dash(f.ate_all, 4),
              number_or_dash(f.rpe, 4),
              Cell(f.mean_iterations, 1),
              Cell(f.total_ms, 1),
              ""};
    } catch (const Error& unreadable) {
      error = unreadable.what();
    }
  }
  std::vector<Cell> row = {run.name, status_text(outcome.status)};
  row.insert(row.end(), 7, Cell("–"));
  row.emplace_back(error.substr(0, error.find('\n')));
  return row;
}

Table table_of(const std::vector<Run>& runs, const Outcomes& outcomes) {
  Table table;
  table.name = "batch";
  table.title = "Runs";
  table.columns = {"run",         "status",     "frames",     "lost", "ATE RMSE (m)", "ATE all frames (m)",
                   "RPE 1 s (m)", "iterations", "ms a frame", "error"};
  table.notes = {
      "ATE of the tracked frames, and of all frames, where a lost one counts with the previous accepted pose; RPE "
      "of all frames; median time a frame."};
  for (std::size_t i = 0; i < runs.size(); ++i) table.rows.push_back(row_of(runs[i], outcomes.runs[i]));
  return table;
}

void write_table(const Table& table, const fs::path& folder) {
  write_file((folder / (table.name + ".csv")).string(), table_csv(table));
  write_file((folder / (table.name + ".json")).string(), table_json(table));
  write_file((folder / (table.name + ".md")).string(), table_markdown(table));
}

/// The first of those that did not come to their end, with their whole messages; the table has all.
void say_failures(const std::vector<Run>& runs, const Outcomes& outcomes) {
  constexpr int kMaxShown = 5;
  int failed = 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const RunOutcome& outcome = outcomes.runs[i];
    if (outcome.status == RunStatus::finished || outcome.error.empty()) continue;
    if (++failed <= kMaxShown) complain(fmt::format("{}: {}", runs[i].name, outcome.error));
  }
  if (failed > kMaxShown) complain(fmt::format("{} more runs failed", failed - kMaxShown));
}

int batch(const BatchArguments& arguments) {
  const std::vector<Run> runs = wanted_runs(arguments);
  if (arguments.dry_run) {
    for (const Run& run : runs) say(command_text(run.arguments));
    return 0;
  }
  ensure_directory(arguments.output);
  const fs::path folder(arguments.output);
  const auto executor = make_executor(arguments.executor, (folder / "slurm").string());
  const Outcomes outcomes = carry_out(runs, *executor, "run", arguments.executor.quiet);
  const Table table = table_of(runs, outcomes);
  write_table(table, folder);
  say("{}", table_text(table));
  say("{} of {} runs are finished; the table is in {}", outcomes.count(RunStatus::finished), runs.size(),
      (folder / "batch.{md,csv,json}").string());
  flush_output();
  if (outcomes.signal != 0) {
    say("interrupted; the same command goes on");
    return 128 + outcomes.signal;
  }
  say_failures(runs, outcomes);
  return outcomes.all_finished() ? 0 : kExitError;
}

void add_grid_options(CLI::App& command, BatchArguments& a) {
  const auto list = [&](const char* name, auto& values, const char* help, const char* type) {
    return command.add_option(name, values, help)->delimiter(',')->capture_default_str()->type_name(type);
  };
  command.add_option("sequences", a.grid.sequences, "Folders, as `plumbline run` takes them")
      ->required()
      ->type_name("SEQUENCE");
  list("--preset", a.grid.presets, "Presets", "NAME,…")->allow_extra_args(false);
  command.add_option("--vary", a.variations, "A parameter and its values; may be repeated, every one with every other")
      ->allow_extra_args(false)
      ->type_name("GROUP.NAME=V1,V2,…");
  list("--orientation", a.grid.orientations,
       "none, or files of readings; a relative path lies in the sequence's folder", "FILE,…")
      ->allow_extra_args(false);
  list("--imu-model", a.grid.imu_models, "Error models that are added to the readings: ideal, bno055", "NAME,…")
      ->allow_extra_args(false);
  command.add_option("--seeds", a.grid.seeds, "Seeds 1 to N of an error model")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str()
      ->type_name("N");
  list("--stride", a.grid.strides, "Take every Nth frame", "N,…")
      ->check(CLI::Range(1, 1 << 30))
      ->allow_extra_args(false);
}

void add_common_options(CLI::App& command, BatchArguments& a) {
  command.add_option("-o,--output", a.output, "Folder of the runs' folders and of the table")
      ->capture_default_str()
      ->type_name("DIR");
  command.add_option("--config", a.config, "TOML file with parameters, for all runs")
      ->check(CLI::ExistingFile)
      ->type_name("FILE");
  command.add_option("--set", a.settings, "One parameter, for all runs; may be repeated")
      ->allow_extra_args(false)
      ->type_name("GROUP.NAME=VALUE");
  command.add_option("--max-frames", a.max_frames, "Stop after so many frames, 0 for all")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str()
      ->type_name("N");
  command.add_flag("--no-mesh", a.no_mesh, "Do not extract and write meshes");
  command.add_option("--run-options", a.run_options, "Further options of `plumbline run`, for all runs")
      ->type_name("\"OPTIONS\"");
  command.add_flag("--dry-run", a.dry_run, "Print the commands, and stop");
}

}  // namespace

void add_batch_command(CLI::App& app, Command& chosen) {
  const auto arguments = std::make_shared<BatchArguments>();
  CLI::App* command =
      app.add_subcommand("batch", "Many runs: every sequence with every preset, setting, orientation …");
  add_grid_options(*command, *arguments);
  add_common_options(*command, *arguments);
  add_executor_arguments(*command, arguments->executor);
  command->footer(
      "Each run is a `plumbline run` with a folder of its own below DIR. Those that are finished are kept, so the "
      "same\n"
      "command goes on where it was broken off, and a larger grid makes what is missing. A run that fails is named;\n"
      "the others go on. The table is written as batch.md, batch.csv and batch.json.");
  command->callback([arguments, &chosen] { chosen = [arguments] { return batch(*arguments); }; });
}

}  // namespace plumbline::app
