#include "lab/run_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "cli/arguments.h"
#include "plumbline/config.h"

namespace plumbline::app {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxParts = 64;  // of a path, in a name

/// The last `parts` of a path, joined.
std::string tail(const fs::path& path, int parts) {
  std::string name = path.filename().string();
  fs::path above = path.parent_path();
  for (int i = 1; i < parts && above.has_filename(); ++i, above = above.parent_path())
    name = above.filename().string() + "_" + name;
  return name;
}

fs::path clean(const std::string& path) {
  fs::path absolute = fs::absolute(path).lexically_normal();
  return absolute.has_filename() ? absolute : absolute.parent_path();
}

/// Fit for a folder's name on any system.
std::string in_a_name(std::string text) {
  std::replace_if(
      text.begin(), text.end(),
      [](char c) { return std::string_view("/\\ :*?\"<>|[]").find(c) != std::string_view::npos; }, '_');
  return text;
}

/// A choice that is made: what it adds to the name and to the command.
struct Choice {
  std::string name;
  std::vector<std::string> arguments;
};
using Choices = std::vector<Choice>;

Choices preset_choices(const Grid& grid) {
  Choices choices;
  for (const std::string& name : grid.presets) {
    as_usage([&] { return preset(name); });
    choices.push_back({"-" + name, {"--preset", name}});
  }
  return choices;
}

Choices variation_choices(const Variation& variation) {
  Choices choices;
  for (const std::string& value : variation.second) {
    const std::string setting = variation.first + "=" + value;
    Parameters scratch;
    as_usage([&] { apply_setting(setting, &scratch); });
    choices.push_back({"-" + in_a_name(setting), {"--set", setting}});
  }
  return choices;
}

bool has_error(const std::string& model) { return !model.empty() && model != "ideal"; }

Choices sensor_choices(const Grid& grid, const fs::path& sequence) {
  Choices choices;
  for (const std::string& file : grid.orientations) {
    if (file == "none") {
      choices.push_back({"", {"--orientation", "none"}});  // nor the sensor that the recording may hold
      continue;
    }
    for (const std::string& model : grid.imu_models)
      for (int seed = 1; seed <= (has_error(model) ? grid.seeds : 1); ++seed)
        choices.push_back({"-" + in_a_name(fs::path(file).stem().string()) + (model.empty() ? "" : "-" + model) +
                               (has_error(model) ? fmt::format("-seed{}", seed) : ""),
                           sensor_arguments({(sequence / file).string(), model, seed})});
  }
  return choices;
}

Choices stride_choices(const Grid& grid) {
  Choices choices;
  for (const int stride : grid.strides)
    choices.push_back(stride == 1 ? Choice{}
                                  : Choice{fmt::format("-stride{}", stride), {"--stride", std::to_string(stride)}});
  return choices;
}

/// Every one of the first with every one of the second.
Choices product(const Choices& first, const Choices& second) {
  Choices all;
  for (const Choice& a : first)
    for (const Choice& b : second) {
      all.push_back({a.name + b.name, a.arguments});
      all.back().arguments.insert(all.back().arguments.end(), b.arguments.begin(), b.arguments.end());
    }
  return all;
}

void check_distinct(const std::vector<Run>& runs) {
  std::set<std::string> names;
  for (const Run& run : runs)
    if (!names.insert(run.name).second)
      throw UsageError("the grid holds this run twice", run.name, "Give each sequence and each value once.");
}

}  // namespace

std::vector<std::string> split_values(const std::string& text) {
  std::vector<std::string> values(1);
  int depth = 0;
  for (const char c : text) {
    depth += (c == '[') - (c == ']');
    if (c == ',' && depth == 0)
      values.emplace_back();
    else
      values.back() += c;
  }
  return values;
}

Variation parse_variation(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw UsageError("'" + text + "' is no key with values", "--vary", "Write --vary orientation.lambda=0.2,1,5.");
  return {text.substr(0, equals), split_values(text.substr(equals + 1))};
}

std::vector<std::string> sequence_names(const std::vector<std::string>& paths) {
  for (int parts = 1;; ++parts) {
    std::vector<std::string> names;
    for (const std::string& path : paths) names.push_back(in_a_name(tail(clean(path), parts)));
    if (parts == kMaxParts || std::set<std::string>(names.begin(), names.end()).size() == names.size()) return names;
  }
}

std::vector<std::string> sensor_arguments(const RunSensor& sensor) {
  if (sensor.file.empty()) return {};
  std::vector<std::string> words = {"--orientation", sensor.file, "--orientation-max-gap", "0.5"};
  if (!sensor.model.empty()) words.insert(words.end(), {"--imu-model", sensor.model});
  if (has_error(sensor.model)) words.insert(words.end(), {"--imu-seed", std::to_string(sensor.seed)});
  return words;
}

namespace {

Run run_of(const Grid& grid, const Choice& choice, const std::string& name, const fs::path& sequence,
           const std::string& output) {
  Run run{name + choice.name, (fs::absolute(output) / (name + choice.name)).string(), {}, grid.incidental};
  run.arguments = {"run", sequence.string(), "-o", run.folder};
  run.arguments.insert(run.arguments.end(), choice.arguments.begin(), choice.arguments.end());
  run.arguments.insert(run.arguments.end(), grid.arguments.begin(), grid.arguments.end());
  return run;
}

}  // namespace

std::vector<Run> runs_of(const Grid& grid, const std::string& output) {
  std::vector<Run> runs;
  const std::vector<std::string> names = sequence_names(grid.sequences);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const fs::path sequence = clean(grid.sequences[i]);
    Choices choices = preset_choices(grid);
    for (const Variation& variation : grid.variations) choices = product(choices, variation_choices(variation));
    choices = product(product(choices, sensor_choices(grid, sequence)), stride_choices(grid));
    for (const Choice& choice : choices) runs.push_back(run_of(grid, choice, names[i], sequence, output));
  }
  check_distinct(runs);
  return runs;
}

}  // namespace plumbline::app
