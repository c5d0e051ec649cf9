// `plumbline eval surface`.
#pragma once

#include "cli/commands.h"

namespace plumbline::app {

/// Adds the subcommand to `eval`.
void add_eval_surface(CLI::App& eval, Command& chosen);

}  // namespace plumbline::app
