// --preset, --quality, --config and --set: the options of every command that reconstructs.
#pragma once

#include <string>
#include <vector>

#include "plumbline/parameters.h"

namespace CLI {
class App;
}

namespace plumbline::app {

struct ParameterArguments {
  std::string preset = "plumbline", quality = "balanced", config;
  std::vector<std::string> settings;
};

void add_parameter_arguments(CLI::App& command, ParameterArguments& arguments);

/// The preset in its quality, then the file's values, then the settings in their order. Throws Error for a bad file,
/// UsageError for the rest.
Parameters effective_parameters(const ParameterArguments& arguments);

}  // namespace plumbline::app
