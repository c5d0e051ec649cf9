#include "commands/eval_trajectories.h"

#include <tbb/parallel_for.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cli/arguments.h"
#include "cli/console.h"
#include "cli/short_names.h"
#include "eval/similarity.h"
#include "eval/time_offset.h"
#include "io/atomic_file.h"
#include "io/csv.h"
#include "io/trajectory.h"
#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/evaluation.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"
#include "report/plot.h"
#include "report/trajectory_plots.h"

namespace plumbline::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kStandardOutput = "-";

struct EvalArguments {
  std::string reference;
  std::vector<std::string> estimates;
  double offset = 0, max_difference = 0.02;  // seconds
  bool find_offset = false, scale = false;
  double offset_range = 0.2;  // seconds
  double delta = 1;
  std::string unit = "s";
  bool all_pairs = false;
  std::string json, csv, plot, view = "auto";
  bool keep_script = false;
};

/// A file that was read, or why it was not.
struct Loaded {
  Trajectory trajectory;
  std::vector<std::string> notes;
  std::string problem;
};

/// An estimate beside the reference; `Result` is the error of the trajectory.
template <class Result>
struct Row {
  std::string path, name;
  Trajectory trajectory;
  std::optional<Result> result;
  std::optional<eval::TimeOffset> offset;
  std::optional<double> scale = {};  ///< that its positions were multiplied by
  std::string problem;               ///< why there is no result
};

template <class Result>
struct Comparison {
  Trajectory reference;
  std::vector<Row<Result>> rows;
};

std::vector<Loaded> load(const std::vector<std::string>& paths) {
  std::vector<Loaded> files(paths.size());
  tbb::parallel_for(std::size_t{0}, paths.size(), [&](std::size_t i) {
    try {
      files[i].trajectory = read_trajectory(paths[i], &files[i].notes);
    } catch (const Error& error) {
      files[i].problem = error.what();
    }
  });
  return files;
}

/// Poses of the world as the camera sees it, where the camera's in the world are meant.
template <class Result>
void hint_inverse(const EvalArguments& arguments, const Trajectory& reference, const Row<Result>& row) {
  const eval::AssociationOptions options{from_seconds(arguments.max_difference), from_seconds(arguments.offset)};
  try {
    if (const auto error = eval::error_if_inverted(reference, row.trajectory, options))
      fmt::print(stderr,
                 "note: {}: inverted, its poses would fit the reference to {:.4f} m: they seem to be camera_from_world "
                 "where world_from_camera is meant\n",
                 row.path, *error);
  } catch (const Error&) {  // too few poses belong together, which the evaluation tells
  }
}

/// With --scale the estimate's positions are multiplied; without it, a hint says so where that would help much.
template <class Result>
void apply_scale(const EvalArguments& arguments, const Trajectory& reference, Row<Result>* row) {
  constexpr double kGain = 0.5, kFar = 0.02;
  const eval::AssociationOptions options{from_seconds(arguments.max_difference), from_seconds(arguments.offset)};
  try {
    const double scale = eval::similarity_scale(reference, row->trajectory, options);
    if (arguments.scale) {
      row->trajectory = eval::scaled(std::move(row->trajectory), scale);
      row->scale = scale;
      return;
    }
    if (std::abs(scale - 1) < kFar) return;
    const auto rmse = [&](const Trajectory& estimate) {
      return eval::absolute_trajectory_error(reference, estimate, options).translation.rmse;
    };
    const double as_it_is = rmse(row->trajectory), better = rmse(eval::scaled(row->trajectory, scale));
    if (better < kGain * as_it_is)
      fmt::print(stderr,
                 "note: {}: {:.4g} times as large it would fit the reference to {:.4f} m instead of {:.4f} m; "
                 "--scale does that, as for a single camera's path\n",
                 row->path, scale, better, as_it_is);
  } catch (const Error&) {  // too few poses belong together, which the evaluation tells
    if (arguments.scale) throw;
  }
}

/// Reads all files and evaluates each estimate. One that fails is told at the end; the others go on.
template <class Result, class Evaluate>
Comparison<Result> compare(const EvalArguments& arguments, Evaluate&& evaluate) {
  std::vector<std::string> paths = {arguments.reference};
  paths.insert(paths.end(), arguments.estimates.begin(), arguments.estimates.end());
  std::vector<Loaded> files = load(paths);
  if (!files[0].problem.empty()) throw std::runtime_error(files[0].problem);
  // On stderr, so that stdout stays for the figures.
  for (std::size_t i = 0; i < files.size(); ++i)
    for (const std::string& note : files[i].notes) fmt::print(stderr, "note: {}: {}\n", paths[i], note);

  Comparison<Result> comparison{std::move(files[0].trajectory), {}};
  const std::vector<std::string> names = short_names(arguments.estimates);
  for (std::size_t i = 0; i < arguments.estimates.size(); ++i) {
    Row<Result> row{arguments.estimates[i], names[i], std::move(files[i + 1].trajectory), {}, {}, {},
                    files[i + 1].problem};
    try {
      if (row.problem.empty()) {
        hint_inverse(arguments, comparison.reference, row);
        apply_scale(arguments, comparison.reference, &row);
      }
      if (row.problem.empty()) row.result = evaluate(comparison.reference, row.trajectory);
    } catch (const Error& error) {
      row.problem = arguments.estimates.size() > 1 ? row.path + ": " + error.what() : error.what();
    }
    comparison.rows.push_back(std::move(row));
  }
  return comparison;
}

// ---- tables

using Values = std::array<double, 6>;
constexpr std::array<const char*, 6> kColumns = {"rmse", "mean", "median", "std", "min", "max"};

Values values(const eval::Statistics& s, double scale) {
  return {scale * s.rmse, scale * s.mean, scale * s.median, scale * s.std, scale * s.min, scale * s.max};
}

/// One quantity of all estimates: a line each.
template <class Result>
void say_table(const Comparison<Result>& comparison, const std::string& title, eval::Statistics Result::*member,
               double scale) {
  std::size_t width = 8;
  for (const auto& row : comparison.rows) width = std::max(width, row.name.size());
  std::string head = fmt::format("{:<{}} {:>8}", title, width, "pairs");
  for (const char* column : kColumns) head += fmt::format(" {:>10}", column);
  say(head);
  for (const auto& row : comparison.rows) {
    std::string line = fmt::format("{:<{}}", row.name, width);
    if (row.result) {
      line += fmt::format(" {:>8}", row.result->pairs.size());
      for (const double value : values((*row.result).*member, scale)) line += fmt::format(" {:>10.6f}", value);
    } else {
      line += fmt::format(" {:>8}", "–");
    }
    say(line);
  }
}

Json statistics_json(const eval::Statistics& s, double scale = 1) {
  Json json;
  const Values all = values(s, scale);
  for (std::size_t i = 0; i < all.size(); ++i) json[kColumns[i]] = all[i];
  return json;
}

Json offset_json(const eval::TimeOffset& offset) {
  return {{"offset_s", to_seconds(offset.best)},
          {"rmse_m", offset.rmse},
          {"rmse_as_given_m", offset.rmse_as_given},
          {"poses", offset.poses},
          {"at_the_border", offset.at_the_border}};
}

void write_json(const std::string& path, const Json& json) {
  // Paths may hold bytes that are not UTF-8, which JSON cannot.
  const std::string text = json.dump(2, ' ', false, Json::error_handler_t::replace);
  if (path == kStandardOutput) return say(text);
  write_file(path, text + "\n");
}

/// Name, number of pairs, and the six figures of each quantity (a column name's beginning, its unit, its values).
struct Quantity {
  const char *name, *unit;
  double scale;
};

template <class Result>
void write_csv(const std::string& path, const Comparison<Result>& comparison,
               const std::vector<std::pair<Quantity, eval::Statistics Result::*>>& quantities) {
  std::string text = "estimate,pairs";
  for (const auto& [quantity, member] : quantities)
    for (const char* column : kColumns) text += fmt::format(",{}_{}_{}", quantity.name, column, quantity.unit);
  text += '\n';
  for (const auto& row : comparison.rows) {
    text += fmt::format("{},{}", csv_field(row.path), row.result ? row.result->pairs.size() : 0);
    for (const auto& [quantity, member] : quantities) {
      const Values all = row.result ? values((*row.result).*member, quantity.scale) : Values{};
      for (const double value : all) text += row.result ? fmt::format(",{:.9g}", value) : ",";
    }
    text += '\n';
  }
  write_file(path, text);
}

/// What failed, on stderr; the exit code.
template <class Result>
int report_problems(const Comparison<Result>& comparison) {
  int code = 0;
  for (const auto& row : comparison.rows) {
    if (row.problem.empty()) continue;
    complain(row.problem);
    code = kExitError;
  }
  return code;
}

template <class Result>
bool has_any(const Comparison<Result>& comparison) {
  return std::any_of(comparison.rows.begin(), comparison.rows.end(), [](const auto& row) { return !!row.result; });
}

/// A long evaluation must not end at a plot that cannot be drawn.
void check_outputs(const EvalArguments& arguments) {
  if (!arguments.plot.empty()) as_usage([&] { check_plot(arguments.plot); });
}

// ---- absolute error

void find_offsets(const EvalArguments& arguments, Comparison<eval::AbsoluteError>* comparison) {
  for (auto& row : comparison->rows) {
    if (!row.result) continue;
    try {
      row.offset = eval::best_time_offset(comparison->reference, row.trajectory,
                                          {from_seconds(arguments.offset_range), from_seconds(arguments.offset)});
    } catch (const Error& error) {
      fmt::print(stderr, "note: {}: {}\n", row.path, error.what());
    }
  }
}

void say_offsets(const Comparison<eval::AbsoluteError>& comparison) {
  for (const auto& row : comparison.rows) {
    if (!row.offset) continue;
    const eval::TimeOffset& o = *row.offset;
    say("clock      {}: rmse {:.6f} m if its stamps were at {:+.4f} s, {:.6f} m as they are (reference interpolated, "
        "{} "
        "poses){}",
        row.name, o.rmse, to_seconds(o.best), o.rmse_as_given, o.poses,
        o.at_the_border ? "; the border of what was searched, try a larger --offset-range" : "");
  }
  say("           not applied; --offset S shifts the stamps");
}

Json ate_json(const EvalArguments& arguments, const Comparison<eval::AbsoluteError>& comparison) {
  Json json = {{"error", "ate"},
               {"groundtruth", arguments.reference},
               {"offset_s", arguments.offset},
               {"max_difference_s", arguments.max_difference},
               {"estimates", Json::array()}};
  for (const auto& row : comparison.rows) {
    Json entry = {{"estimate", row.path}};
    if (row.result) {
      const Eigen::Vector3d t = row.result->reference_from_estimate.translation();
      const Eigen::Quaterniond q = row.result->reference_from_estimate.quaternion();
      entry["pairs"] = row.result->pairs.size();
      if (row.scale) entry["scale"] = *row.scale;
      entry["translation_m"] = statistics_json(row.result->translation);
      entry["reference_from_estimate"] = {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
      if (row.offset) entry["best_offset"] = offset_json(*row.offset);
    } else {
      entry["problem"] = row.problem;
    }
    json["estimates"].push_back(entry);
  }
  return json;
}

void plot_ate(const EvalArguments& arguments, const Comparison<eval::AbsoluteError>& comparison) {
  std::vector<EvaluatedTrajectory> estimates;
  for (const auto& row : comparison.rows)
    if (row.result)
      estimates.push_back({comparison.rows.size() > 1 ? row.name : "estimate", &row.trajectory, &*row.result});
  save_plot(absolute_error_plot(comparison.reference, estimates, view_plane(arguments.view, comparison.reference)),
            arguments.plot, arguments.keep_script);
}

int evaluate_ate(const EvalArguments& arguments) {
  check_outputs(arguments);
  const eval::AssociationOptions options{from_seconds(arguments.max_difference), from_seconds(arguments.offset)};
  auto comparison = compare<eval::AbsoluteError>(arguments, [&](const Trajectory& reference, const Trajectory& e) {
    return eval::absolute_trajectory_error(reference, e, options);
  });
  if (arguments.find_offset) find_offsets(arguments, &comparison);
  if (has_any(comparison)) {
    if (arguments.json != kStandardOutput) {
      say("absolute trajectory error after {} alignment, metres", arguments.scale ? "similarity" : "rigid");
      for (const auto& row : comparison.rows)
        if (row.scale) say("scale      {}: its positions were multiplied by {:.6g}", row.name, *row.scale);
      if (arguments.offset != 0) say("the estimates' stamps were shifted by {} s", arguments.offset);
      say_table(comparison, "estimate", &eval::AbsoluteError::translation, 1);
      if (arguments.find_offset) say_offsets(comparison);
    }
    if (!arguments.csv.empty())
      write_csv<eval::AbsoluteError>(arguments.csv, comparison,
                                     {{{"translation", "m", 1}, &eval::AbsoluteError::translation}});
    if (!arguments.json.empty()) write_json(arguments.json, ate_json(arguments, comparison));
    if (!arguments.plot.empty()) plot_ate(arguments, comparison);
  }
  return report_problems(comparison);
}

// ---- relative error

eval::RelativeErrorOptions relative_options(const EvalArguments& arguments) {
  static const std::map<std::string, eval::DeltaUnit> kUnits = {{"s", eval::DeltaUnit::seconds},
                                                                {"m", eval::DeltaUnit::metres},
                                                                {"rad", eval::DeltaUnit::radians},
                                                                {"frames", eval::DeltaUnit::frames}};
  eval::RelativeErrorOptions options;
  options.all_pairs = arguments.all_pairs;
  options.delta = arguments.delta;
  options.unit = kUnits.at(arguments.unit);
  options.offset = from_seconds(arguments.offset);
  return options;
}

Json rpe_json(const EvalArguments& arguments, const Comparison<eval::RelativeError>& comparison) {
  Json json = {{"error", "rpe"},
               {"groundtruth", arguments.reference},
               {"offset_s", arguments.offset},
               {"all_pairs", arguments.all_pairs}};
  if (!arguments.all_pairs) json["delta"] = {{"value", arguments.delta}, {"unit", arguments.unit}};
  json["estimates"] = Json::array();
  for (const auto& row : comparison.rows) {
    Json entry = {{"estimate", row.path}};
    if (row.result) {
      entry["pairs"] = row.result->pairs.size();
      if (row.scale) entry["scale"] = *row.scale;
      entry["translation_m"] = statistics_json(row.result->translation);
      entry["rotation_deg"] = statistics_json(row.result->rotation, kDegreesPerRadian);
    } else {
      entry["problem"] = row.problem;
    }
    json["estimates"].push_back(entry);
  }
  return json;
}

void plot_rpe(const EvalArguments& arguments, const Comparison<eval::RelativeError>& comparison) {
  std::vector<RelativeTrajectory> estimates;
  for (const auto& row : comparison.rows)
    if (row.result) estimates.push_back({comparison.rows.size() > 1 ? row.name : "", &*row.result});
  save_plot(relative_error_plot(comparison.reference, estimates), arguments.plot, arguments.keep_script);
}

int evaluate_rpe(const EvalArguments& arguments) {
  check_outputs(arguments);
  const eval::RelativeErrorOptions options = relative_options(arguments);
  const auto comparison =
      compare<eval::RelativeError>(arguments, [&](const Trajectory& reference, const Trajectory& estimate) {
        return eval::relative_trajectory_error(reference, estimate, options);
      });
  if (has_any(comparison)) {
    if (arguments.json != kStandardOutput) {
      say("relative pose error over pairs at {}",
          arguments.all_pairs ? "all distances"
                              : fmt::format("a distance of {:g} {}", arguments.delta, arguments.unit));
      if (arguments.offset != 0) say("the estimates' stamps were shifted by {} s", arguments.offset);
      say_table(comparison, "translation (m)", &eval::RelativeError::translation, 1);
      say_table(comparison, "rotation (deg)", &eval::RelativeError::rotation, kDegreesPerRadian);
    }
    if (!arguments.csv.empty())
      write_csv<eval::RelativeError>(arguments.csv, comparison,
                                     {{{"translation", "m", 1}, &eval::RelativeError::translation},
                                      {{"rotation", "deg", kDegreesPerRadian}, &eval::RelativeError::rotation}});
    if (!arguments.json.empty()) write_json(arguments.json, rpe_json(arguments, comparison));
    if (!arguments.plot.empty()) plot_rpe(arguments, comparison);
  }
  return report_problems(comparison);
}

void add_common(CLI::App& command, EvalArguments& arguments) {
  command
      .add_option("groundtruth", arguments.reference,
                  "Reference trajectory: TUM, EuRoC, KITTI, Redwood, or a folder of poses")
      ->required()
      ->type_name("GROUNDTRUTH");
  command.add_option("estimates", arguments.estimates, "Estimated trajectories, one row each")
      ->required()
      ->type_name("ESTIMATE");
  command.add_option("--offset", arguments.offset, "Added to the estimates' stamps, seconds")
      ->check(CLI::Range(-1e9, 1e9))
      ->capture_default_str()
      ->type_name("S");
  command.add_flag("--scale", arguments.scale, "Multiply the estimate's positions by the factor that fits best");
  command
      .add_option("--json", arguments.json, "Write the figures as JSON; without a name or as '-' in place of the table")
      ->expected(0, 1)
      ->default_str(kStandardOutput)
      ->type_name("FILE");
  command.add_option("--csv", arguments.csv, "Write the table, a row for each estimate")->type_name("FILE");
  command.add_option("--plot", arguments.plot, "Draw the errors over time; .svg or .png")->type_name("FILE");
  command.add_flag("--keep-script", arguments.keep_script, "Leave the gnuplot script of --plot beside it");
}

}  // namespace

void add_eval_trajectories(CLI::App& eval, Command& chosen) {
  const auto arguments = std::make_shared<EvalArguments>();
  CLI::App* ate = eval.add_subcommand("ate", "Absolute trajectory error");
  add_common(*ate, *arguments);
  ate->add_option("--max-difference", arguments->max_difference, "Stamps that belong together differ by less, seconds")
      ->check(CLI::Range(1e-9, 1e6))
      ->capture_default_str()
      ->type_name("S");
  ate->add_option("--view", arguments->view, "Plane of the plotted way: xy, xz, yz, or auto for the widest")
      ->check(CLI::IsMember({"auto", "xy", "xz", "yz"}))
      ->capture_default_str();
  ate->add_flag("--find-offset", arguments->find_offset,
                "Report the shift of the estimates' stamps with the smallest error; it is not applied");
  ate->add_option("--offset-range", arguments->offset_range, "How far --find-offset searches to both sides, seconds")
      ->check(CLI::Range(1e-3, 3600.0))
      ->capture_default_str()
      ->type_name("S");
  ate->callback([arguments, &chosen] { chosen = [arguments] { return evaluate_ate(*arguments); }; });

  CLI::App* rpe = eval.add_subcommand("rpe", "Relative pose error");
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
}

}  // namespace plumbline::app
