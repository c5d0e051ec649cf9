#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "cli/commands.h"
#include "commands/eval_surface.h"
#include "commands/eval_trajectories.h"

namespace plumbline::app {

void add_eval_command(CLI::App& app, Command& chosen) {
  CLI::App* command = app.add_subcommand("eval", "Compare trajectories or a mesh with the truth");
  command->require_subcommand(1);
  add_eval_trajectories(*command, chosen);
  add_eval_surface(*command, chosen);
}

}  // namespace plumbline::app
