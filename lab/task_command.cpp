#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "cli/commands.h"
#include "cli/interrupt.h"
#include "io/text_file.h"
#include "lab/executor.h"
#include "plumbline/error.h"

namespace plumbline::app {
namespace {

struct TaskArguments {
  std::string list;
  int index = 0;
};

/// As the local executor carries out a run, so that both leave the same.
int task(const TaskArguments& arguments) {
  const RunList list = parse_run_list(read_file(arguments.list), arguments.list);
  const auto index = static_cast<std::size_t>(arguments.index);
  if (index >= list.runs.size()) throw Error("the list has no such run", arguments.list, "");
  const InterruptGuard interrupt;
  int code = 0;
  RunWatch watch;
  watch.interrupted = [&] { return interrupt.signal() != 0; };
  watch.ended = [&](const Run& run, const RunOutcome& outcome) {
    if (outcome.status == RunStatus::none) throw Error(outcome.error, run.name, "");
    if (outcome.status != RunStatus::finished) code = kExitError;
  };
  make_local_executor(1)->execute(list.program, {list.runs[index]}, watch);
  return interrupt.signal() != 0 ? 128 + interrupt.signal() : code;
}

}  // namespace

void add_task_command(CLI::App& app, Command& chosen) {
  const auto arguments = std::make_shared<TaskArguments>();
  CLI::App* command = app.add_subcommand("task", "One run of a list that `batch` or `reproduce` wrote");
  command->group("");  // not listed
  command->add_option("list", arguments->list)->required()->type_name("FILE");
  command->add_option("index", arguments->index)->required()->check(CLI::NonNegativeNumber);
  command->callback([arguments, &chosen] { chosen = [arguments] { return task(*arguments); }; });
}

}  // namespace plumbline::app
