// The subcommands of the program, one file each.
#pragma once

#include <functional>
#include <string>

namespace CLI {
class App;
}

namespace plumbline::app {

/// What the command line asked for; returns the exit code. Set by the callback of the subcommand that was given.
using Command = std::function<int()>;

/// Exit codes besides 0; a run that a signal ended early returns 128 + the signal's number (130 for Ctrl-C).
constexpr int kExitError = 1;
constexpr int kExitUsage = 2;

/// `command_line` is told in the summary of the run.
void add_run_command(CLI::App& app, Command& chosen, const std::string& command_line);
void add_info_command(CLI::App& app, Command& chosen);
void add_convert_command(CLI::App& app, Command& chosen);
void add_angles_command(CLI::App& app, Command& chosen, const std::string& command_line);
void add_calibrate_command(CLI::App& app, Command& chosen, const std::string& command_line);
void add_eval_command(CLI::App& app, Command& chosen);
void add_render_command(CLI::App& app, Command& chosen);
void add_plot_command(CLI::App& app, Command& chosen);
void add_view_command(CLI::App& app, Command& chosen);
void add_demo_command(CLI::App& app, Command& chosen, const std::string& command_line);
void add_simulate_command(CLI::App& app, Command& chosen);
void add_download_command(CLI::App& app, Command& chosen);
void add_record_command(CLI::App& app, Command& chosen);
void add_orientation_command(CLI::App& app, Command& chosen);
void add_characterise_command(CLI::App& app, Command& chosen);
void add_backends_command(CLI::App& app, Command& chosen);
void add_batch_command(CLI::App& app, Command& chosen);
void add_reproduce_command(CLI::App& app, Command& chosen);
/// One run of a list, for a scheduler; not for people, and not listed.
void add_task_command(CLI::App& app, Command& chosen);
void add_bench_command(CLI::App& app, Command& chosen);

}  // namespace plumbline::app
