#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <thread>

#include "lab/child_process.h"
#include "lab/executor.h"
#include "plumbline/error.h"

namespace plumbline::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kPoll{20};

/// A pool in one thread: children are looked after in turn, so that nothing is shared and a signal finds us awake.
class LocalExecutor : public Executor {
 public:
  explicit LocalExecutor(int jobs) : jobs_(static_cast<std::size_t>(jobs)) {}

  void execute(const std::string& program, const std::vector<Run>& runs, const RunWatch& watch) override {
    std::size_t next = 0;
    bool asked = false;
    while (!running_.empty() || (next < runs.size() && !watch.interrupted())) {
      if (watch.interrupted() && !asked) {
        // A reconstruction finishes its frame and writes what it has.
        for (const Child& child : running_) kill(-child.pid, SIGINT);
        asked = true;
      }
      while (!watch.interrupted() && running_.size() < jobs_ && next < runs.size()) start(program, runs[next++], watch);
      if (!collect(watch)) std::this_thread::sleep_for(kPoll);
    }
  }

 private:
  struct Child {
    const Run* run;
    pid_t pid;
    Clock::time_point start;
  };

  /// What keeps one run from starting (its folder, mostly) need not keep the others.
  void start(const std::string& program, const Run& run, const RunWatch& watch) {
    try {
      begin_record(run);
      std::vector<std::string> arguments = run.arguments;
      arguments.insert(arguments.end(), run.incidental.begin(), run.incidental.end());
      running_.push_back({&run, start_program(program, arguments, log_path(run)), Clock::now()});
    } catch (const Error& error) {
      watch.ended(run, {RunStatus::none, error.what(), 0});
    }
  }

  /// Whether any child has ended.
  bool collect(const RunWatch& watch) {
    bool any = false;
    for (std::size_t i = 0; i < running_.size();) {
      int status = 0;
      const pid_t ended = waitpid(running_[i].pid, &status, WNOHANG);
      if (ended == 0 || (ended < 0 && errno == EINTR)) {
        ++i;
        continue;
      }
      const Child child = running_[i];
      running_.erase(running_.begin() + static_cast<std::ptrdiff_t>(i));
      any = true;
      finish(child, status, watch);
    }
    return any;
  }

  static void finish(const Child& child, int status, const RunWatch& watch) {
    const bool good = WIFEXITED(status) && WEXITSTATUS(status) == 0;
    if (watch.interrupted() && !good) return;  // it was told to end: no failure, and no record
    const double seconds = std::chrono::duration<double>(Clock::now() - child.start).count();
    try {
      watch.ended(*child.run, write_record(*child.run, status, seconds));
    } catch (const Error& error) {
      watch.ended(*child.run, {RunStatus::none, error.what(), seconds});
    }
  }

  std::size_t jobs_;
  std::vector<Child> running_;
};

}  // namespace

std::unique_ptr<Executor> make_local_executor(int jobs) { return std::make_unique<LocalExecutor>(jobs); }

}  // namespace plumbline::app
