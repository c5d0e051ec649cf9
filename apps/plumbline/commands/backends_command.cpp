#include <CLI/CLI.hpp>

#include "backend/backend.h"
#include "cli/commands.h"
#include "cli/console.h"

namespace plumbline::app {

void add_backends_command(CLI::App& app, Command& chosen) {
  CLI::App* command = app.add_subcommand("backends", "List what this program can compute with");
  command->callback([&chosen] {
    chosen = [] {
      for (const BackendInfo& backend : list_backends())
        say("{:<6} {:<14} {}", backend.name, backend.available ? "available" : "not available", backend.description);
      return 0;
    };
  });
}

}  // namespace plumbline::app
