#include "cli/backend_arguments.h"

#include <CLI/CLI.hpp>

namespace plumbline::app {

void add_threads_argument(CLI::App& command, int& threads) {
  command.add_option("--threads", threads, "CPU threads, 0 for all; the result does not depend on it")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str()
      ->type_name("N");
}

void add_backend_arguments(CLI::App& command, std::string& backend, int& threads) {
  command.add_option("--backend", backend, "Where to compute; `plumbline backends` lists them")
      ->capture_default_str()
      ->type_name("NAME");
  add_threads_argument(command, threads);
}

}  // namespace plumbline::app
