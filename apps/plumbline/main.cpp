// The command line: chooses a command, runs it, and turns what went wrong into a message and an exit code.
#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <string>

#include "cli/arguments.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "plumbline/error.h"

namespace plumbline::app {
namespace {

/// Runs the command; every way to fail ends in a line on stderr that says what to do.
int run_command(const Command& command) {
  try {
    const int code = command();
    flush_output();
    return code;
  } catch (const UsageError& error) {
    complain(error.what());
    return kExitUsage;
  } catch (const std::bad_alloc&) {
    complain("out of memory\n  Make the volume smaller, for example --set volume.resolution=256.");
  } catch (const std::exception& error) {
    complain(error.what());
  }
  return kExitError;
}

// Those of lab/, in the order of `plumbline --help`.
#ifdef PLUMBLINE_LAB
void add_lab_commands(CLI::App& app, Command& chosen, const std::string& command_line) {
  add_angles_command(app, chosen, command_line);
  add_plot_command(app, chosen);
  add_batch_command(app, chosen);
  add_reproduce_command(app, chosen);
  add_task_command(app, chosen);
  add_bench_command(app, chosen);
}
#else
/// Commands that only say how to get them; not listed.
void add_lab_commands(CLI::App& app, Command& chosen, const std::string&) {
  for (const char* name : {"angles", "plot", "batch", "reproduce", "bench"}) {
    CLI::App* command = app.add_subcommand(name, "")->group("")->allow_extras();
    command->set_help_flag();
    command->callback([&chosen, name] {
      chosen = [name]() -> int {
        throw UsageError("this program was built without the command, as ./dev demo builds it", name,
                         "Build the whole program: ./dev build.");
      };
    });
  }
}
#endif

int run(int argc, char** argv) {
  CLI::App app("Dense 3D reconstruction from depth images.", "plumbline");
  app.set_version_flag("--version", std::string("plumbline ") + PLUMBLINE_VERSION);
  app.require_subcommand(1);
  Command chosen;
  const std::string line = command_text({argv, argv + argc});
  add_run_command(app, chosen, line);
  add_info_command(app, chosen);
  add_convert_command(app, chosen);
  add_calibrate_command(app, chosen, line);
  add_eval_command(app, chosen);
  add_render_command(app, chosen);
  add_view_command(app, chosen);
  add_demo_command(app, chosen, line);
  add_simulate_command(app, chosen);
  add_download_command(app, chosen);
  add_record_command(app, chosen);
  add_orientation_command(app, chosen);
  add_characterise_command(app, chosen);
  add_backends_command(app, chosen);
  add_lab_commands(app, chosen, line);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    complain(std::string(error.what()) + "\n  `plumbline --help` and `plumbline COMMAND --help` list what there is.");
    return kExitUsage;
  }
  return run_command(chosen);
}

}  // namespace
}  // namespace plumbline::app

int main(int argc, char** argv) {
  // A reader that closes our pipe, or a limit on file sizes, must not kill a run: the failed write is reported instead.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    return plumbline::app::run(argc, argv);
  } catch (...) {  // only if even the message could not be made
    std::fputs("plumbline: error: out of memory\n", stderr);
    return plumbline::app::kExitError;
  }
}
