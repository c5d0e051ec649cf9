#include "lab/executor.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <thread>

#include "cli/console.h"
#include "cli/interrupt.h"
#include "cli/progress.h"
#include "lab/child_process.h"
#include "lab/split_words.h"

namespace plumbline::app {
namespace {

bool is_wanted(const RunOutcome& outcome) {
  return outcome.status != RunStatus::finished && outcome.status != RunStatus::foreign;
}

/// The first line; the advice that follows is for the log.
std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

/// What was told of each run, by its folder.
using Told = std::map<std::string, RunOutcome>;

Told execute(const std::vector<Run>& wanted, Executor& executor, const std::string& what, bool quiet,
             const InterruptGuard& interrupt) {
  Progress progress(static_cast<int>(wanted.size()), quiet, {what, "finished", "failed", 1});
  int finished = 0, failed = 0;
  Told told;
  RunWatch watch;
  watch.interrupted = [&] { return interrupt.signal() != 0; };
  watch.note = [&](const std::string& line) { progress.note(line); };
  watch.ended = [&](const Run& run, const RunOutcome& outcome) {
    const bool good = outcome.status == RunStatus::finished;
    ++(good ? finished : failed);
    told[run.folder] = outcome;
    if (!good) progress.note(fmt::format("{} failed: {}", run.name, first_line(outcome.error)));
    progress.update(finished + failed, finished, failed);
  };
  progress.update(0, 0, 0);
  executor.execute(own_program(), wanted, watch);
  return told;
}

}  // namespace

int Outcomes::count(RunStatus status) const {
  return static_cast<int>(
      std::count_if(runs.begin(), runs.end(), [&](const RunOutcome& run) { return run.status == status; }));
}

Outcomes carry_out(const std::vector<Run>& runs, Executor& executor, const std::string& what, bool quiet) {
  check_folders(runs);
  Outcomes outcomes;
  std::vector<Run> wanted;
  for (const Run& run : runs) {
    const RunOutcome outcome = outcome_of(run);
    outcomes.kept += outcome.status == RunStatus::finished;
    if (is_wanted(outcome)) wanted.push_back(run);
  }
  if (!quiet && outcomes.kept > 0) say("{} of {} {}s are finished already", outcomes.kept, runs.size(), what);
  Told told;
  if (!wanted.empty()) {
    const InterruptGuard interrupt;
    told = execute(wanted, executor, what, quiet, interrupt);
    outcomes.signal = interrupt.signal();
  }
  for (const Run& run : runs) {
    outcomes.runs.push_back(outcome_of(run));
    // A run that could not even leave a record.
    if (outcomes.runs.back().status == RunStatus::none && told.contains(run.folder))
      outcomes.runs.back() = told[run.folder];
  }
  return outcomes;
}

void add_executor_arguments(CLI::App& command, ExecutorArguments& a) {
  command.add_option("--executor", a.executor, "local: processes of this machine; slurm: a Slurm job array")
      ->check(CLI::IsMember({"local", "slurm"}))
      ->capture_default_str()
      ->type_name("NAME");
  command.add_option("--jobs", a.jobs, "So many runs at a time; 0: as many as there are processors (slurm: no limit)")
      ->check(CLI::Range(0, 100000))
      ->capture_default_str()
      ->type_name("N");
  command.add_option("--threads", a.threads, "CPU threads of a run; the result does not depend on it")
      ->check(CLI::Range(1, 4096))
      ->capture_default_str()
      ->type_name("N");
  command.add_option("--slurm", a.slurm, "Options of sbatch, such as \"--partition=short --time=1:00:00\"")
      ->type_name("\"OPTIONS\"");
  command.add_option("--retries", a.retries, "How often Slurm gets runs again that were broken off")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str()
      ->type_name("N");
  command.add_flag("--quiet", a.quiet, "Print nothing but results and errors");
}

std::unique_ptr<Executor> make_executor(const ExecutorArguments& a, const std::string& folder, int jobs) {
  if (jobs == 0) jobs = a.jobs;
  if (a.executor == "slurm") {
    SlurmOptions options;
    options.folder = std::filesystem::absolute(folder).string();
    options.jobs = jobs;
    options.threads = a.threads;
    options.retries = a.retries;
    options.options = split_words(a.slurm);
    return make_slurm_executor(options);
  }
  const int processors = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  return make_local_executor(jobs > 0 ? jobs : std::max(1, processors / a.threads));
}

std::vector<std::string> incidental_arguments(const ExecutorArguments& a) {
  return {"--threads", std::to_string(a.threads), "--quiet"};
}

}  // namespace plumbline::app
