// Where to compute, on the command line.
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace plumbline::app {

/// --threads, for results that do not depend on it.
void add_threads_argument(CLI::App& command, int& threads);

/// --backend and --threads, as `make_backend` takes them.
void add_backend_arguments(CLI::App& command, std::string& backend, int& threads);

}  // namespace plumbline::app
