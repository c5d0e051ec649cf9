#include <CLI/CLI.hpp>
#include <memory>

#include "app/commands.h"
#include "app/console.h"
#include "app/sequence_arguments.h"
#include "app/sequence_text.h"

namespace plumbline::app {
namespace {

int show_info(const SequenceArguments& arguments) {
  const auto sequence = open_sequence(arguments.path, sequence_options(arguments));
  for (const std::string& line : describe(*sequence)) say(line);
  const Timing times = timing(*sequence);
  if (times.median_interval > 0)
    say("intervals  {:.1f} ms (median), longest {:.3f} s, {:.2f} s after the start", 1e3 * times.median_interval,
        times.longest_gap, times.longest_gap_start);
  return 0;
}

}  // namespace

void add_info_command(CLI::App& app, Command& chosen) {
  const auto arguments = std::make_shared<SequenceArguments>();
  CLI::App* command = app.add_subcommand("info", "Tell what a sequence holds and what would be assumed about it");
  add_sequence_arguments(*command, *arguments, true);
  command->callback([arguments, &chosen] { chosen = [arguments] { return show_info(*arguments); }; });
}

}  // namespace plumbline::app
