// `plumbline eval ate` and `plumbline eval rpe`.
#pragma once

#include "cli/commands.h"

namespace plumbline::app {

void add_eval_trajectories(CLI::App& eval, Command& chosen);

}  // namespace plumbline::app
