#include "cli/parameter_arguments.h"

#include <CLI/CLI.hpp>

#include "cli/arguments.h"
#include "plumbline/config.h"

namespace plumbline::app {

void add_parameter_arguments(CLI::App& command, ParameterArguments& arguments) {
  command.add_option("--preset", arguments.preset, "Set of parameters to start from")
      ->capture_default_str()
      ->type_name("NAME");
  command.add_option("--quality", arguments.quality, "Of preset plumbline: fast, balanced or best; slower is finer")
      ->capture_default_str()
      ->type_name("NAME");
  command.add_option("--config", arguments.config, "TOML file with parameters, on top of the preset")
      ->type_name("FILE");
  command.add_option("--set", arguments.settings, "One parameter, on top of the file; may be repeated")
      ->allow_extra_args(false)
      ->type_name("GROUP.NAME=VALUE");
}

Parameters effective_parameters(const ParameterArguments& arguments) {
  Parameters parameters = as_usage([&] { return preset(arguments.preset); });
  if (arguments.preset != "plumbline" && arguments.quality != "balanced")
    throw UsageError("the published presets have one quality", "--quality " + arguments.quality,
                     "Leave it out, or take --preset plumbline.");
  as_usage([&] { apply_quality(arguments.quality, &parameters); });
  if (!arguments.config.empty()) load_parameters(arguments.config, &parameters);
  as_usage([&] {
    for (const std::string& setting : arguments.settings) apply_setting(setting, &parameters);
  });
  return parameters;
}

}  // namespace plumbline::app
