#include <CLI/CLI.hpp>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "cli/console.h"
#include "cli/sensor_model.h"
#include "io/csv.h"
#include "plumbline/angles.h"
#include "plumbline/files.h"
#include "plumbline/orientation.h"
#include "report/plot.h"
#include "sensor/characterisation.h"

namespace plumbline::app {
namespace {

constexpr const char* kEarthAxes[] = {"X (east)", "Y (north)", "Z (up)"};

struct CharacteriseArguments {
  std::string reference, readings, plot, csv, model;
  CharacterisationOptions options;
  bool quiet = false;
};

std::vector<OrientationSample> load(const std::string& path) {
  std::vector<std::string> notes;
  std::vector<OrientationSample> samples = read_orientations(path, {}, &notes);
  for (const std::string& note : notes) fmt::print(stderr, "note: {}: {}\n", path, note);
  return samples;
}

void say_table(const Characterisation& study) {
  say("axis       angle     readings  systematic  random   combined  expanded (k = 2), degrees");
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const RestReadings& rest : study.axes[axis].rests)
      say("{:<9} {:>8.2f} {:>10} {:>11.3f} {:>8.3f} {:>9.3f} {:>9.3f}", kEarthAxes[axis], degrees(rest.angle),
          rest.count, degrees(rest.systematic), degrees(rest.random), degrees(rest.combined()),
          degrees(rest.expanded()));
}

void say_summary(const Characterisation& study) {
  for (const std::string& note : study.notes) say("note       {}", note);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const AxisStudy& a = study.axes[axis];
    if (a.rests.empty())
      say("{:<10} was not turned about", kEarthAxes[axis]);
    else
      say("{:<10} {} angles: systematic within ±{:.2f}° ({:.2f}° rms), random {:.3f}°, combined {:.2f}°, expanded "
          "(k = 2) {:.2f}°",
          kEarthAxes[axis], a.rests.size(), degrees(a.amplitude), degrees(a.systematic), degrees(a.random),
          degrees(a.combined()), 2 * degrees(a.combined()));
  }
}

void write_csv(const Characterisation& study, const std::string& path) {
  CsvWriter csv(path,
                {"axis", "angle_deg", "readings", "systematic_deg", "random_deg", "combined_deg", "expanded_deg"});
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const RestReadings& r : study.axes[axis].rests)
      csv.row({std::string(1, "xyz"[axis]), fmt::format("{:.6f}", degrees(r.angle)), std::to_string(r.count),
               fmt::format("{:.6f}", degrees(r.systematic)), fmt::format("{:.6f}", degrees(r.random)),
               fmt::format("{:.6f}", degrees(r.combined())), fmt::format("{:.6f}", degrees(r.expanded()))});
  csv.close();
}

/// As the paper's figure: the systematic part over the angle about each axis, with the readings' spread (k = 2).
Panel panel_of(const AxisStudy& axis, const char* name) {
  Series points{"systematic part", {}, {}, Mark::points}, spread{"random part, k = 2", {}, {}, Mark::line, "#999999"},
      fit{"fit", {}, {}, Mark::line};
  constexpr double kGap = std::numeric_limits<double>::quiet_NaN();
  for (const RestReadings& rest : axis.rests) {
    points.x.push_back(degrees(rest.angle));
    points.y.push_back(degrees(rest.systematic));
    for (const double side : {-2.0, 2.0, kGap}) {
      spread.x.push_back(degrees(rest.angle));
      spread.y.push_back(degrees(rest.systematic + side * rest.random));
    }
  }
  for (int degree = -180; degree <= 180 && !axis.rests.empty(); ++degree) {
    fit.x.push_back(degree);
    fit.y.push_back(degrees(axis.fit.at(radians(degree))));
  }
  points.width = 4;
  Panel panel;
  panel.title = std::string("about ") + name;
  panel.x = {"reference angle, degrees", -180, 180};
  panel.y = {"error, degrees"};
  panel.series = {spread, fit, points};
  return panel;
}

void draw(const Characterisation& study, const std::string& path) {
  Plot plot;
  plot.title = "Error of the orientation sensor";
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!study.axes[axis].rests.empty()) plot.panels.push_back(panel_of(study.axes[axis], kEarthAxes[axis]));
  plot.panel_height = 260;
  save_plot(plot, path);
}

int characterise_sensor(const CharacteriseArguments& a) {
  if (!a.plot.empty()) check_plot(a.plot);
  const Characterisation study = characterise(load(a.reference), load(a.readings), a.options);
  if (!a.quiet) say_table(study);
  say_summary(study);
  if (!a.csv.empty()) write_csv(study, a.csv);
  if (!a.plot.empty()) draw(study, a.plot);
  if (!a.model.empty()) write_sensor_model(a.model, study);
  return 0;
}

void add_options(CLI::App& command, CharacteriseArguments& a) {
  command.add_option("--reference", a.reference, "True orientations: t qx qy qz qw, two stamps or more of each rest")
      ->required()
      ->type_name("FILE");
  command.add_option("--readings", a.readings, "The sensor's, same axes and clock")->required()->type_name("FILE");
  command.add_option("--settling", a.options.settling, "Seconds of each rest that are left out")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  command.add_option("--harmonics", a.options.harmonics, "Of the fitted error functions")
      ->check(CLI::Range(1, 50))
      ->capture_default_str();
  command.add_option("-o,--model", a.model, "Write the model: for run --imu-model and --sensor-model")
      ->type_name("FILE.toml");
  command.add_option("--csv", a.csv, "Write the table")->type_name("FILE.csv");
  command.add_option("--plot", a.plot, "Draw the error over the angle")->type_name("FILE.svg|png");
  command.add_flag("--quiet", a.quiet, "Print the summary without the table");
}

}  // namespace

void add_characterise_command(CLI::App& app, Command& chosen) {
  const auto arguments = std::make_shared<CharacteriseArguments>();
  CLI::App* command = app.add_subcommand("characterise", "How far an orientation sensor can be trusted (GUM)");
  add_options(*command, *arguments);
  command->callback([arguments, &chosen] { chosen = [arguments] { return characterise_sensor(*arguments); }; });
}

}  // namespace plumbline::app
