#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "app/commands.h"
#include "app/console.h"
#include "app/eval_surface.h"
#include "core/time.h"
#include "eval/trajectory_error.h"
#include "io/trajectory.h"

namespace plumbline::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegrees = 180 / std::numbers::pi;

struct EvalArguments {
  std::string reference, estimate;
  double offset = 0, max_difference = 0.02;  // seconds
  double delta = 1;
  std::string unit = "s";
  bool all_pairs = false, json = false;
};

struct Trajectories {
  Trajectory reference, estimate;
};

/// Both files; what had to be repaired in them is said on stderr, so that stdout stays for the figures.
Trajectories load(const EvalArguments& arguments) {
  std::vector<std::string> notes;
  Trajectories both{read_trajectory(arguments.reference, &notes), read_trajectory(arguments.estimate, &notes)};
  for (const std::string& note : notes) fmt::print(stderr, "note: {}\n", note);
  return both;
}

Json to_json(const eval::Statistics& s, double scale = 1) {
  return {{"rmse", scale * s.rmse}, {"mean", scale * s.mean}, {"median", scale * s.median},
          {"std", scale * s.std},   {"min", scale * s.min},   {"max", scale * s.max}};
}

void say_statistics(const char* name, const eval::Statistics& s, const char* unit, double scale = 1) {
  say("{:<12} rmse {:.6f}  mean {:.6f}  median {:.6f}  std {:.6f}  min {:.6f}  max {:.6f}  {}", name, scale * s.rmse,
      scale * s.mean, scale * s.median, scale * s.std, scale * s.min, scale * s.max, unit);
}

int evaluate_ate(const EvalArguments& arguments) {
  const auto [reference, estimate] = load(arguments);
  const eval::AbsoluteError error = eval::absolute_trajectory_error(
      reference, estimate, {from_seconds(arguments.max_difference), from_seconds(arguments.offset)});
  if (arguments.json) {
    Json json = {{"pairs", error.pairs.size()}, {"offset_s", arguments.offset}};
    json["translation_m"] = to_json(error.translation);
    say(json.dump(2));
    return 0;
  }
  say("absolute trajectory error over {} pairs, after rigid alignment", error.pairs.size());
  if (arguments.offset != 0) say("the estimate's stamps were shifted by {} s", arguments.offset);
  say_statistics("translation", error.translation, "m");
  return 0;
}

int evaluate_rpe(const EvalArguments& arguments) {
  static const std::map<std::string, eval::DeltaUnit> kUnits = {{"s", eval::DeltaUnit::seconds},
                                                                {"m", eval::DeltaUnit::metres},
                                                                {"rad", eval::DeltaUnit::radians},
                                                                {"frames", eval::DeltaUnit::frames}};
  const auto [reference, estimate] = load(arguments);
  eval::RelativeErrorOptions options;
  options.all_pairs = arguments.all_pairs;
  options.delta = arguments.delta;
  options.unit = kUnits.at(arguments.unit);
  options.offset = from_seconds(arguments.offset);
  const eval::RelativeError error = eval::relative_trajectory_error(reference, estimate, options);
  if (arguments.json) {
    Json json = {{"pairs", error.pairs.size()}, {"all_pairs", arguments.all_pairs}, {"offset_s", arguments.offset}};
    if (!arguments.all_pairs) json["delta"] = {{"value", arguments.delta}, {"unit", arguments.unit}};
    json["translation_m"] = to_json(error.translation);
    json["rotation_deg"] = to_json(error.rotation, kDegrees);
    say(json.dump(2));
    return 0;
  }
  const std::string span =
      arguments.all_pairs ? "all distances" : fmt::format("a distance of {:g} {}", arguments.delta, arguments.unit);
  say("relative pose error over {} pairs at {}", error.pairs.size(), span);
  if (arguments.offset != 0) say("the estimate's stamps were shifted by {} s", arguments.offset);
  say_statistics("translation", error.translation, "m");
  say_statistics("rotation", error.rotation, "deg", kDegrees);
  return 0;
}

void add_common(CLI::App& command, EvalArguments& arguments) {
  command.add_option("groundtruth", arguments.reference, "Reference trajectory (TUM format)")
      ->required()
      ->type_name("GROUNDTRUTH");
  command.add_option("estimate", arguments.estimate, "Estimated trajectory (TUM format)")
      ->required()
      ->type_name("ESTIMATE");
  command.add_option("--offset", arguments.offset, "Added to the estimate's stamps, seconds")
      ->check(CLI::Range(-1e9, 1e9))
      ->capture_default_str()
      ->type_name("S");
  command.add_flag("--json", arguments.json, "Print JSON");
}

}  // namespace

void add_eval_command(CLI::App& app, Command& chosen) {
  const auto arguments = std::make_shared<EvalArguments>();
  CLI::App* command = app.add_subcommand("eval", "Compare a trajectory or a mesh with the truth");
  command->require_subcommand(1);

  CLI::App* ate = command->add_subcommand("ate", "Absolute trajectory error");
  add_common(*ate, *arguments);
  ate->add_option("--max-difference", arguments->max_difference, "Stamps that belong together differ by less, seconds")
      ->check(CLI::Range(1e-9, 1e6))
      ->capture_default_str()
      ->type_name("S");
  ate->callback([arguments, &chosen] { chosen = [arguments] { return evaluate_ate(*arguments); }; });

  CLI::App* rpe = command->add_subcommand("rpe", "Relative pose error");
  add_common(*rpe, *arguments);
  rpe->add_option("--delta", arguments->delta, "Distance between the poses of a pair")
      ->check(CLI::PositiveNumber)
      ->capture_default_str()
      ->type_name("D");
  rpe->add_option("--unit", arguments->unit, "Of --delta: s, m, rad or frames")
      ->check(CLI::IsMember({"s", "m", "rad", "frames"}))
      ->capture_default_str()
      ->type_name("UNIT");
  rpe->add_flag("--all-pairs", arguments->all_pairs, "Every pair of poses (thinned to 10000) in place of --delta");
  rpe->callback([arguments, &chosen] { chosen = [arguments] { return evaluate_rpe(*arguments); }; });
  add_eval_surface(*command, chosen);
}

}  // namespace plumbline::app
