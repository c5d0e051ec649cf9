// Carries out lists of runs: those that are finished are kept, the others are run again.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "lab/run_list.h"

namespace CLI {
class App;
}

namespace plumbline::app {

/// What an executor tells while it works, and is told.
struct RunWatch {
  std::function<void(const Run&, const RunOutcome&)> ended = [](const Run&, const RunOutcome&) {};
  std::function<void(const std::string&)> note = [](const std::string&) {};
  std::function<bool()> interrupted = [] { return false; };
};

/// Where runs are carried out.
class Executor {
 public:
  virtual ~Executor() = default;
  /// Carries out all of the runs, each as `program ARGUMENTS…`, in any order; each leaves its record in its folder. A
  /// run that fails does not keep the others. After `watch.interrupted()`: asks those that run to end, starts no more,
  /// and returns when none is left. Throws Error for what concerns all of the runs.
  virtual void execute(const std::string& program, const std::vector<Run>& runs, const RunWatch& watch) = 0;
};

/// Processes of this machine, so many at a time.
std::unique_ptr<Executor> make_local_executor(int jobs);

struct SlurmOptions {
  std::string folder;                ///< for scripts and lists; every node must see it
  int jobs = 0;                      ///< at a time; 0 = as many as Slurm likes
  int threads = 1;                   ///< processors of a run
  int retries = 2;                   ///< times that runs without an end of their own are submitted again
  std::vector<std::string> options;  ///< of sbatch
  double poll_seconds = 2;
  std::string task_program;  ///< that knows `task`; empty = this one
};
/// A Slurm job array, a task for each run. Throws Error where Slurm's commands are missing.
std::unique_ptr<Executor> make_slurm_executor(const SlurmOptions& options);

/// --executor, --jobs and what belongs to them.
struct ExecutorArguments {
  std::string executor = "local", slurm;
  int jobs = 0, threads = 1, retries = 2;
  bool quiet = false;
};
void add_executor_arguments(CLI::App& command, ExecutorArguments& arguments);
/// `folder`: for what the executor itself writes. `jobs`: in place of the arguments' where not 0.
std::unique_ptr<Executor> make_executor(const ExecutorArguments& arguments, const std::string& folder, int jobs = 0);
/// The incidental arguments of runs.
std::vector<std::string> incidental_arguments(const ExecutorArguments& arguments);

struct Outcomes {
  std::vector<RunOutcome> runs;  ///< one a run
  int kept = 0;                  ///< that were finished before
  int signal = 0;                ///< that ended the work early, or 0

  int count(RunStatus status) const;
  bool all_finished() const { return count(RunStatus::finished) == static_cast<int>(runs.size()); }
};

/// Carries out those of the runs that are not finished, with a progress bar; those that fail are named as they do.
/// `what` names one of them: "run". Throws Error where two runs share a folder, and what the executor throws.
Outcomes carry_out(const std::vector<Run>& runs, Executor& executor, const std::string& what, bool quiet);

}  // namespace plumbline::app
