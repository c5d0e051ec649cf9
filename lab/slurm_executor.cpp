#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <sstream>
#include <thread>

#include "cli/arguments.h"
#include "io/atomic_file.h"
#include "io/text_file.h"
#include "lab/child_process.h"
#include "lab/executor.h"
#include "plumbline/error.h"

namespace plumbline::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kAdvice =
    "Run on a machine that submits to a Slurm cluster (Debian: slurm-client), or with --executor local.";
constexpr std::size_t kUsualArray = 1000;  // MaxArraySize is 1001 unless it was changed
constexpr int kPatience = 30;              // times in a row that squeue may fail

std::string trimmed(const std::string& text) { return std::string(trim(text)); }

/// Runs a command of Slurm; its output. Throws Error with what it said.
std::string slurm(const std::vector<std::string>& words) {
  const Captured done = capture(words);
  if (done.exit_code == 127) throw Error("there is no such command", words.front(), kAdvice);
  if (done.exit_code != 0)
    throw Error(fmt::format("Slurm refuses (exit code {}): {}", done.exit_code, trimmed(done.err)), command_text(words),
                "Check the options given with --slurm, and `sinfo`.");
  return done.out;
}

/// Tasks that one array may have: the value of "MaxArraySize = 1001" is one more than the greatest index.
std::size_t largest_array() {
  const Captured config = capture({"scontrol", "show", "config"});
  const std::size_t at = config.out.find("MaxArraySize");
  if (config.exit_code != 0 || at == std::string::npos) return kUsualArray;
  const std::size_t equals = config.out.find('=', at), end = config.out.find('\n', at);
  const auto size = parse_unsigned(trim(std::string_view(config.out).substr(equals + 1, end - equals - 1)));
  return size && *size > 0 ? static_cast<std::size_t>(*size) : kUsualArray;
}

/// An array that was submitted.
struct Array {
  std::string id;
  std::vector<const Run*> runs;  // a task each
};

class SlurmExecutor : public Executor {
 public:
  explicit SlurmExecutor(const SlurmOptions& options) : options_(options) {
    if (options_.task_program.empty()) options_.task_program = own_program();
    slurm({"sbatch", "--version"});
  }

  void execute(const std::string& program, const std::vector<Run>& runs, const RunWatch& watch) override {
    ensure_directory(options_.folder);
    wait_for_earlier(watch);
    std::vector<const Run*> open;
    for (const Run& run : runs)
      if (outcome_of(run).status == RunStatus::finished)
        watch.ended(run, outcome_of(run));  // by the earlier call
      else
        open.push_back(&run);
    for (int attempt = 0; !open.empty() && !watch.interrupted(); ++attempt) {
      if (attempt > 0) watch.note(fmt::format("{} runs were broken off and are submitted again", open.size()));
      const bool is_final = attempt == options_.retries;
      open = attempt_all(program, open, is_final, watch);
      if (is_final) break;
    }
  }

 private:
  /// One submission of the runs, and the wait for it. Gives those that are worth another.
  std::vector<const Run*> attempt_all(const std::string& program, const std::vector<const Run*>& runs, bool is_final,
                                      const RunWatch& watch) {
    for (const Run* run : runs) begin_record(*run);
    const std::vector<Array> arrays = submit(program, runs);
    remember(arrays);
    std::vector<const Run*> open = runs;
    while (!watch.interrupted() && in_queue(arrays)) {
      collect(&open, false, watch);
      pause(watch);
    }
    if (watch.interrupted()) cancel(arrays);
    // A shared file system may be late.
    for (int look = 0; look < 3 && !watch.interrupted() && lacks_record(open); ++look) pause(watch);
    if (!watch.interrupted()) forget();  // what was cancelled may take a while to end: the next call waits for it
    collect(&open, is_final && !watch.interrupted(), watch);
    return open;
  }

  std::vector<Array> submit(const std::string& program, const std::vector<const Run*>& runs) {
    std::vector<Array> arrays;
    const std::size_t largest = largest_array();
    for (std::size_t begin = 0; begin < runs.size(); begin += largest) {
      const std::size_t end = std::min(runs.size(), begin + largest);
      arrays.push_back(submit_array(program, {runs.begin() + static_cast<std::ptrdiff_t>(begin),
                                              runs.begin() + static_cast<std::ptrdiff_t>(end)}));
    }
    return arrays;
  }

  Array submit_array(const std::string& program, const std::vector<const Run*>& runs) {
    std::vector<Run> list;
    for (const Run* run : runs) list.push_back(*run);
    const std::string name = unused_name(), runs_file = path(name + ".json"), script = path(name + ".sh");
    write_file(runs_file, run_list_json(program, list));
    write_file(script, script_text(runs_file, runs.size()));
    std::vector<std::string> words = {"sbatch", "--parsable"};
    words.insert(words.end(), options_.options.begin(), options_.options.end());
    words.push_back(script);
    const std::string answer = trimmed(slurm(words));
    return {answer.substr(0, answer.find(';')), runs};  // "ID" or "ID;CLUSTER"
  }

  std::string script_text(const std::string& runs_file, std::size_t tasks) const {
    const std::string throttle = options_.jobs > 0 ? fmt::format("%{}", options_.jobs) : "";
    return fmt::format(
        "#!/bin/sh\n"
        "#SBATCH --job-name=plumbline\n"
        "#SBATCH --array=0-{}{}\n"
        "#SBATCH --ntasks=1\n"
        "#SBATCH --cpus-per-task={}\n"
        "#SBATCH --output={}\n"
        "exec {} \"$SLURM_ARRAY_TASK_ID\"\n",
        tasks - 1, throttle, options_.threads, command_text({path("task-%A_%a.txt")}),
        command_text({options_.task_program, "task", runs_file}));
  }

  /// Whether any task waits or runs. Slurm forgets a job some minutes after its end.
  bool in_queue(const std::vector<Array>& arrays) {
    std::vector<std::string> ids;
    for (const Array& array : arrays) ids.push_back(array.id);
    return in_queue(ids);
  }

  bool in_queue(const std::vector<std::string>& ids) {
    bool any = false;
    for (const std::string& id : ids) {
      const Captured answer = capture({"squeue", "--noheader", "--format=%T", "--jobs=" + id});
      if (answer.exit_code == 0) {
        failures_ = 0;
        any |= !trim(answer.out).empty();
      } else if (answer.err.find("Invalid job id") == std::string::npos) {
        if (++failures_ > kPatience)
          throw Error("squeue does not answer: " + trimmed(answer.err), "Slurm",
                      "The runs may go on; the same command waits for them.");
        any = true;
      }
    }
    return any;
  }

  /// Tells of the runs that have an end of their own, and takes them out; of all, where the attempt `is_final`.
  void collect(std::vector<const Run*>* open, bool is_final, const RunWatch& watch) const {
    std::erase_if(*open, [&](const Run* run) {
      RunOutcome outcome = outcome_of(*run);
      const bool ended = outcome.status == RunStatus::finished || outcome.status == RunStatus::failed;
      if (!ended && !is_final) return false;
      if (outcome.error.empty() && !ended)
        outcome.error = fmt::format("Slurm ended it before it was through, {} times; see {}", options_.retries + 1,
                                    path("task-*.txt"));
      watch.ended(*run, outcome);
      return true;
    });
  }

  static bool lacks_record(const std::vector<const Run*>& runs) {
    return std::any_of(runs.begin(), runs.end(),
                       [](const Run* run) { return outcome_of(*run).status == RunStatus::none; });
  }

  static void cancel(const std::vector<Array>& arrays) {
    for (const Array& array : arrays) capture({"scancel", array.id});
  }

  void pause(const RunWatch& watch) const {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(options_.poll_seconds);
    while (!watch.interrupted() && std::chrono::steady_clock::now() < end)
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }

  /// A call that lost its terminal leaves its jobs; the next must not start the same runs beside them.
  void remember(const std::vector<Array>& arrays) const {
    std::string ids;
    for (const Array& array : arrays) ids += array.id + "\n";
    write_file(path("jobs.txt"), ids);
  }
  void forget() const {
    std::error_code ignored;
    fs::remove(path("jobs.txt"), ignored);
  }
  void wait_for_earlier(const RunWatch& watch) {
    if (!fs::exists(path("jobs.txt"))) return;
    std::vector<std::string> ids;
    std::istringstream lines(read_file(path("jobs.txt")));
    for (std::string id; std::getline(lines, id);) ids.push_back(id);
    bool told = false;
    while (!watch.interrupted() && in_queue(ids)) {
      if (!told) watch.note(fmt::format("waiting for the jobs of an earlier call ({})", fmt::join(ids, ", ")));
      told = true;
      pause(watch);
    }
    if (!watch.interrupted()) forget();
  }

  std::string unused_name() const {
    for (int i = 1;; ++i)
      if (const std::string name = fmt::format("runs-{}", i); !fs::exists(path(name + ".json"))) return name;
  }

  std::string path(const std::string& name) const { return (fs::path(options_.folder) / name).string(); }

  SlurmOptions options_;
  int failures_ = 0;
};

}  // namespace

std::unique_ptr<Executor> make_slurm_executor(const SlurmOptions& options) {
  return std::make_unique<SlurmExecutor>(options);
}

}  // namespace plumbline::app
