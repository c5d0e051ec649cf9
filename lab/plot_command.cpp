#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/arguments.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/short_names.h"
#include "io/atomic_file.h"
#include "io/text_file.h"
#include "io/trajectory.h"
#include "lab/run_plots.h"
#include "plumbline/error.h"
#include "plumbline/evaluation.h"
#include "plumbline/trajectory.h"
#include "report/plot.h"
#include "report/trajectory_plots.h"

namespace plumbline::app {
namespace {

namespace fs = std::filesystem;

struct PlotArguments {
  std::string folder, output, format = "svg", view = "auto", groundtruth;
  std::string iterations;
  std::vector<std::string> tables;
  bool no_paper = false, keep_script = false;
};

void draw(const PlotArguments& arguments, const Plot& plot, const std::string& path) {
  save_plot(plot, path, arguments.keep_script);
  say(path);
}

/// The trajectory that the run was evaluated against, or empty: a run need not have had one.
std::string truth_of_run(const fs::path& folder) {
  const fs::path summary = folder / "summary.json";
  if (!fs::exists(summary)) return "";
  const auto json = nlohmann::json::parse(read_file(summary.string()), nullptr, false);
  if (!json.is_object() || !json.contains("ate") || !json["ate"].is_object()) return "";
  return json["ate"].value("groundtruth", "");
}

/// With the truth where that is known and can be read.
Plot way_plot(const PlotArguments& arguments, const fs::path& folder) {
  const Trajectory estimate = read_trajectory((folder / "trajectory.txt").string());
  const std::string truth = arguments.groundtruth.empty() ? truth_of_run(folder) : arguments.groundtruth;
  if (!truth.empty()) {
    try {
      const Trajectory reference = read_trajectory(truth);
      const eval::AbsoluteError error = eval::absolute_trajectory_error(reference, estimate);
      return absolute_error_plot(reference, {{"estimate", &estimate, &error}}, view_plane(arguments.view, reference));
    } catch (const Error& error) {
      if (!arguments.groundtruth.empty()) throw;
      fmt::print(stderr, "note: drawn without the truth: {}\n", error.what());
    }
  }
  return path_plot("estimate", estimate, view_plane(arguments.view, estimate));
}

/// Numbers of the frames whose iterations were dumped.
std::vector<fs::path> iteration_files(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("icp_") && name.ends_with(".json")) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

int plot_run(const PlotArguments& arguments) {
  const fs::path folder = arguments.folder;
  const bool has_frames = fs::exists(folder / "frames.csv"), has_way = fs::exists(folder / "trajectory.txt");
  if (!has_frames && !has_way)
    throw Error("holds no frames.csv and no trajectory.txt", arguments.folder,
                "Give the folder that `plumbline run` wrote.");
  const fs::path output = arguments.output.empty() ? folder : fs::path(arguments.output);
  check_plot("plot." + arguments.format);
  ensure_directory(output.string());
  const auto path = [&](const std::string& name) { return (output / (name + "." + arguments.format)).string(); };
  if (has_way) draw(arguments, way_plot(arguments, folder), path("trajectory"));
  if (has_frames) draw(arguments, frames_plot((folder / "frames.csv").string()), path("frames"));
  for (const fs::path& file : iteration_files(folder))
    draw(arguments, iterations_plot(file.string()), path(file.stem().string()));
  return 0;
}

int plot_iterations(const PlotArguments& arguments) {
  as_usage([&] { check_plot(arguments.output); });
  draw(arguments, iterations_plot(arguments.iterations), arguments.output);
  return 0;
}

int plot_angles(const PlotArguments& arguments) {
  as_usage([&] { check_plot(arguments.output); });
  std::vector<std::string> names = short_names(arguments.tables);
  for (std::string& name : names)
    if (name.ends_with(".csv")) name.erase(name.size() - 4);
  if (names.size() == 1) names[0] = fs::path(names[0]).filename().string();
  draw(arguments, angles_plot(arguments.tables, names, !arguments.no_paper), arguments.output);
  return 0;
}

void add_output(CLI::App& command, PlotArguments& arguments) {
  command.add_option("-o,--output", arguments.output, "File that ends in .svg or .png")->required()->type_name("FILE");
}

void add_run(CLI::App& plot, const std::shared_ptr<PlotArguments>& arguments, Command& chosen) {
  CLI::App* run = plot.add_subcommand("run", "What `plumbline run` left: trajectory, frames, and dumped iterations");
  run->add_option("folder", arguments->folder, "Output of a run")->required()->type_name("DIR");
  run->add_option("-o,--output", arguments->output, "Folder for the plots (default: the run's)")->type_name("DIR");
  run->add_option("--format", arguments->format, "svg or png")
      ->check(CLI::IsMember({"svg", "png"}))
      ->capture_default_str();
  run->add_option("--groundtruth", arguments->groundtruth, "True trajectory (default: the run's)")->type_name("FILE");
  run->add_option("--view", arguments->view, "Plane of the way: xy, xz, yz, or auto for the widest")
      ->check(CLI::IsMember({"auto", "xy", "xz", "yz"}))
      ->capture_default_str();
  run->callback([arguments, &chosen] { chosen = [arguments] { return plot_run(*arguments); }; });
}

}  // namespace

void add_plot_command(CLI::App& app, Command& chosen) {
  const auto arguments = std::make_shared<PlotArguments>();
  CLI::App* command = app.add_subcommand("plot", "Draw what other commands left as SVG or PNG");
  command->require_subcommand(1);
  command->add_flag("--keep-script", arguments->keep_script, "Leave the gnuplot scripts, with their data, too");
  add_run(*command, arguments, chosen);

  CLI::App* iterations = command->add_subcommand("icp", "Distance distribution over the iterations of a frame");
  iterations->add_option("file", arguments->iterations, "icp_N.json of `plumbline run --dump-icp N`")
      ->required()
      ->type_name("FILE");
  add_output(*iterations, *arguments);
  iterations->callback([arguments, &chosen] { chosen = [arguments] { return plot_iterations(*arguments); }; });

  CLI::App* angles = command->add_subcommand("angles", "Failures over the angle between two frames");
  angles->add_option("tables", arguments->tables, "Tables of `plumbline angles --csv`, a curve each")
      ->required()
      ->type_name("FILE");
  angles->add_flag("--no-paper", arguments->no_paper, "Without the published curves");
  add_output(*angles, *arguments);
  angles->callback([arguments, &chosen] { chosen = [arguments] { return plot_angles(*arguments); }; });
}

}  // namespace plumbline::app
