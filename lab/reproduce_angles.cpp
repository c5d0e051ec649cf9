// Table "Failure rate across intra-frame acquisition angles", on simulated pairs of frames.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "io/text_file.h"
#include "lab/angular_report.h"
#include "lab/reproduce.h"
#include "lab/run_grid.h"
#include "plumbline/error.h"

namespace plumbline::app {
namespace {

namespace fs = std::filesystem;

struct AngleRow {
  const char *name, *preset, *sensor;
};
constexpr AngleRow kAngleRows[] = {{"Original", "kinectfusion", "none"},
                                   {"Ours: seed, damping, ideal IMU", "paper", "ideal"},
                                   {"Ours: seed, damping, with error", "paper", "bno055"},
                                   {"plumbline, no IMU", "plumbline", "none"},
                                   {"plumbline, ideal IMU", "plumbline", "ideal"},
                                   {"plumbline, with error", "plumbline", "bno055"}};

/// One place after another, the camera turned at each; as fast as it takes for the 8 s of the path to be through in
/// these frames at 30 a second, so that the places lie all along it. Without the sensor's static distortion: two single
/// frames that see a thing in different parts of the image would contradict each other by more than a success allows.
Run turns(const ReproduceOptions& options, const std::string& scene, double angle) {
  Run run;
  run.name = fmt::format("turns-{}-{}-{:g}-{}", options.turn_axis, scene, angle, options.pairs);
  run.folder = fs::absolute(fs::path(options.output) / "sequences" / run.name).lexically_normal().string();
  run.incidental = options.incidental;
  run.arguments = {"simulate",
                   "-o",
                   run.folder,
                   "--scene",
                   scene,
                   "--trajectory",
                   "handheld",
                   "--speed",
                   fmt::format("{:g}", std::min(100.0, 120.0 / options.pairs)),
                   "--turn",
                   fmt::format("{:g}", angle),
                   "--turn-axis",
                   options.turn_axis,
                   "--frames",
                   std::to_string(2 * options.pairs),
                   "--no-color",
                   "--distortion",
                   "0"};
  return run;
}

std::string figures_file(const Run& run) { return (fs::path(run.folder) / "angles.json").string(); }

Run test(const ReproduceOptions& options, const std::string& scene, double angle, const AngleRow& row, int seed) {
  const Run sequence = turns(options, scene, angle);
  Run run;
  run.name = fmt::format("{}-{}-{}-{}", sequence.name, row.preset, row.sensor, seed);
  run.folder = fs::absolute(fs::path(options.output) / "runs" / run.name).lexically_normal().string();
  // `angles` says what it does, and has no --quiet.
  run.incidental = options.incidental;
  std::erase(run.incidental, "--quiet");
  run.arguments = {
      "angles",   sequence.folder, "--angles", fmt::format("{:g}", angle), "--pairs", std::to_string(options.pairs),
      "--preset", row.preset,      "--json",   figures_file(run)};
  std::vector<std::string> more = volume_arguments(row.preset);
  if (std::string(row.sensor) != "none") {
    const std::vector<std::string> sensor =
        sensor_arguments({(fs::path(sequence.folder) / "groundtruth.txt").string(), row.sensor, seed});
    more.insert(more.end(), sensor.begin(), sensor.end());
  }
  run.arguments.insert(run.arguments.end(), more.begin(), more.end());
  return run;
}

struct Count {
  int failures = 0, pairs = 0;
  bool complete = true;

  Cell cell() const {
    if (!complete || pairs == 0) return Cell("–");
    return {100.0 * failures / pairs, 0, "%"};
  }
};

Count& operator+=(Count& sum, const Count& part) {
  sum.failures += part.failures;
  sum.pairs += part.pairs;
  sum.complete &= part.complete;
  return sum;
}

Count count(const Run& run) {
  if (outcome_of(run).status != RunStatus::finished) return {0, 0, false};
  try {
    const auto json = nlohmann::json::parse(read_file(figures_file(run)));
    const auto& angle = json.at("angles").at(0);
    return {angle.at("failures"), angle.at("pairs"), true};
  } catch (const Error&) {
  } catch (const nlohmann::json::exception&) {
  }
  return {0, 0, false};
}

std::vector<Count> counts(const ReproduceOptions& options, const std::string& scene, const AngleRow& row) {
  std::vector<Count> result;
  for (const double angle : options.angles) {
    Count sum;
    for (const int seed : seeds_of(row.sensor, options.seeds)) sum += count(test(options, scene, angle, row, seed));
    result.push_back(sum);
  }
  return result;
}

std::vector<Cell> row_cells(const std::string& scene, const std::string& name, const std::vector<Count>& counts) {
  std::vector<Cell> cells = {scene, name};
  for (const Count& c : counts) cells.push_back(c.cell());
  return cells;
}

std::vector<Cell> paper_cells(const ReproduceOptions& options, const char* name, const std::array<int, 9>& failures) {
  std::vector<Cell> cells = {"paper: Desktop", name};
  for (const double angle : options.angles) {
    const auto known = std::find(kPaperAngles.begin(), kPaperAngles.end(), angle);
    cells.push_back(known == kPaperAngles.end()
                        ? Cell("–")
                        : Cell(failures[static_cast<std::size_t>(known - kPaperAngles.begin())], 0, "%"));
  }
  return cells;
}

Series series_of(const std::string& name, const std::vector<double>& angles, const std::vector<Cell>& cells,
                 Mark mark) {
  Series series{name, {}, {}, mark};
  for (std::size_t i = 0; i < angles.size(); ++i)
    if (cells[i + 2].value) {
      series.x.push_back(angles[i]);
      series.y.push_back(*cells[i + 2].value);
    }
  return series;
}

std::string axis_text(const ReproduceOptions& options) {
  return options.turn_axis == "pan" ? "to the left or to the right" : "about any axis across the line of sight";
}

ReproduceResult angles_result(const ReproduceOptions& options) {
  Table table;
  table.name = "angles";
  table.title =
      "Failure rate across angles between two frames (paper: table \"Failure rate across intra-frame acquisition "
      "angles\")";
  table.columns = {"scene", "method"};
  for (const double angle : options.angles) table.columns.push_back(fmt::format("{:g}°", angle));
  Plot plot{.title = "Failures over the angle between two frames", .panels = {Panel{}}};
  plot.panels[0].x = {.label = "angle (°)"};
  plot.panels[0].y = {.label = "failures (%)", .low = 0, .high = 105};
  std::map<std::string, std::vector<Count>> all;
  for (const std::string& scene : options.scenes)
    for (const AngleRow& row : kAngleRows) {
      const std::vector<Count> found = counts(options, scene, row);
      std::vector<Count>& sum = all[row.name];
      sum.resize(found.size());
      for (std::size_t i = 0; i < found.size(); ++i) sum[i] += found[i];
      table.rows.push_back(row_cells(scene, row.name, found));
    }
  for (const AngleRow& row : kAngleRows) {
    const std::vector<Cell> cells = row_cells("all", row.name, all[row.name]);
    if (options.scenes.size() > 1) table.rows.push_back(cells);
    plot.panels[0].series.push_back(series_of(row.name, options.angles, cells, Mark::line_points));
  }
  table.rows.push_back(paper_cells(options, "Original", kPaperOriginal));
  plot.panels[0].series.push_back(series_of("paper: Original", options.angles, table.rows.back(), Mark::dashed));
  table.rows.push_back(paper_cells(options, "Ours", kPaperImu));
  plot.panels[0].series.push_back(series_of("paper: Ours", options.angles, table.rows.back(), Mark::dashed));
  table.notes = {
      fmt::format("{} simulated pairs for each scene and angle, the camera turned {}; a first frame fused alone, the "
                  "second registered to it; a success lies within 2 cm and 1° of the truth. \"With error\": the error "
                  "model of a BNO055, seeds 1 to {} together. The paper's pairs were recorded, and judged by eye.",
                  options.pairs, axis_text(options), options.seeds)};
  return {{table}, {{"angles", plot}}};
}

}  // namespace

Plan plan_angles(const ReproduceOptions& options) {
  Plan plan;
  for (const std::string& scene : options.scenes)
    for (const double angle : options.angles) {
      plan.sequences.push_back(turns(options, scene, angle));
      for (const AngleRow& row : kAngleRows)
        for (const int seed : seeds_of(row.sensor, options.seeds))
          plan.runs.push_back(test(options, scene, angle, row, seed));
    }
  plan.result = [options] { return angles_result(options); };
  return plan;
}

}  // namespace plumbline::app
