#include "lab/run_plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "io/csv.h"
#include "io/text_file.h"
#include "lab/angular_report.h"
#include "plumbline/error.h"
#include "plumbline/frame.h"
#include "plumbline/statistics.h"

namespace plumbline::app {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr double kMillimetres = 1e3;

/// NaN for an empty field.
std::vector<double> numbers(const CsvTable& table, const std::string& name, double scale = 1) {
  const std::size_t column = table.column(name);
  std::vector<double> values;
  for (const auto& row : table.rows) values.push_back(scale * parse_double(row[column]).value_or(kNothing));
  return values;
}

/// `values` of the frames that were registered; the others are gaps.
std::vector<double> where(const std::vector<bool>& shown, std::vector<double> values) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!shown[i]) values[i] = kNothing;
  return values;
}

// ---- iterations

struct Iteration {
  int level = 0;
  double pairs = 0, median = 0, rms = 0;  // metres
  std::vector<double> histogram;          // counts
};

struct Iterations {
  int frame = 0;
  double bin_width = 0;  // metres
  std::vector<Iteration> list;
};

Iterations read_iterations(const std::string& path) {
  try {
    const nlohmann::json json = nlohmann::json::parse(read_file(path).c_str());
    Iterations all{json.at("frame").get<int>(), json.at("bin_width_m").get<double>(), {}};
    for (const nlohmann::json& entry : json.at("iterations"))
      all.list.push_back({entry.at("level").get<int>(), entry.at("pairs").get<double>(),
                          entry.at("median_distance_m").get<double>(), entry.at("rms_m").get<double>(),
                          entry.at("histogram").get<std::vector<double>>()});
    return all;
  } catch (const nlohmann::json::exception& error) {
    throw Error(std::string("does not hold the iterations of a frame: ") + error.what(), path,
                "Give an icp_N.json that `plumbline run --dump-icp N` wrote.");
  }
}

/// Metres below which nearly all distances of these iterations lie.
double far_end(const std::vector<const Iteration*>& iterations, double bin_width) {
  constexpr double kPart = 0.98;
  std::size_t used = 1;
  for (const Iteration* iteration : iterations) {
    double total = 0, sum = 0;
    for (const double count : iteration->histogram) total += count;
    for (std::size_t bin = 0; bin < iteration->histogram.size() && sum < kPart * total; ++bin) {
      sum += iteration->histogram[bin];
      used = std::max(used, bin + 1);
    }
  }
  return static_cast<double>(used) * bin_width;
}

/// From pale to dark as the iterations go on.
std::string shade(std::size_t index, std::size_t count) {
  const double part = count > 1 ? static_cast<double>(index) / static_cast<double>(count - 1) : 1;
  const auto mix = [&](int pale, int dark) { return static_cast<int>(std::lround(pale + part * (dark - pale))); };
  return fmt::format("#{:02x}{:02x}{:02x}", mix(0xa6, 0x08), mix(0xcb, 0x30), mix(0xee, 0x6b));
}

/// Part of the pairs per millimetre, in bins joined to about `bins` over the range shown.
Series distribution(const Iteration& iteration, double bin_width, double end) {
  constexpr double kBins = 80;
  const auto join = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(end / bin_width / kBins)));
  double total = 0;
  for (const double count : iteration.histogram) total += count;
  Series series;
  const double width = static_cast<double>(join) * bin_width * kMillimetres;
  for (std::size_t begin = 0; begin + join <= iteration.histogram.size(); begin += join) {
    const double centre = (static_cast<double>(begin) + 0.5 * static_cast<double>(join)) * bin_width * kMillimetres;
    if (centre > end * kMillimetres) break;
    double count = 0;
    for (std::size_t bin = begin; bin < begin + join; ++bin) count += iteration.histogram[bin];
    series.x.push_back(centre);
    series.y.push_back(total > 0 ? 100 * count / total / width : kNothing);
  }
  return series;
}

Panel level_panel(const Iterations& all, int level) {
  std::vector<const Iteration*> own;
  for (const Iteration& iteration : all.list)
    if (iteration.level == level) own.push_back(&iteration);
  const double end = far_end(own, all.bin_width);
  Panel panel{.title = fmt::format("Distances at level {}", level),
              .x = {.label = "distance of a pair (mm)", .low = 0, .high = end * kMillimetres},
              .y = {.label = "pairs (% per mm)", .low = 0}};
  for (std::size_t i = 0; i < own.size(); ++i) {
    panel.series.push_back(distribution(*own[i], all.bin_width, end));
    panel.series.back().color = shade(i, own.size());
    const bool at_the_end = i == 0 || i + 1 == own.size();
    if (at_the_end) panel.series.back().name = fmt::format("iteration {}", i + 1);
  }
  return panel;
}

/// A line for each level: from one level to the next the residual is another.
Panel convergence_panel(const Iterations& all, const std::vector<int>& levels) {
  Panel panel{.title = "Convergence", .x = {.label = "iteration"}, .y = {.label = "mm", .log = true}};
  for (std::size_t i = 0; i < levels.size(); ++i) {
    Series median{.name = fmt::format("median distance, level {}", levels[i]), .mark = Mark::line_points},
        rms{.name = fmt::format("residual (rms), level {}", levels[i]), .mark = Mark::dashed};
    median.color = rms.color = plot_color(i);
    for (std::size_t k = 0; k < all.list.size(); ++k) {
      if (all.list[k].level != levels[i]) continue;
      for (Series* series : {&median, &rms}) series->x.push_back(static_cast<double>(k + 1));
      median.y.push_back(kMillimetres * all.list[k].median);
      rms.y.push_back(kMillimetres * all.list[k].rms);
    }
    panel.series.push_back(median);
    panel.series.push_back(rms);
  }
  return panel;
}

// ---- angles

struct AngleFigures {
  int pairs = 0, failures = 0;
  std::vector<double> translation;  // metres, of the successes
};

std::map<double, AngleFigures> read_angles(const std::string& path) {
  const CsvTable table = read_csv(path);
  const std::vector<double> angles = numbers(table, "angle_deg"), success = numbers(table, "success"),
                            translation = numbers(table, "translation_error_m");
  std::map<double, AngleFigures> figures;
  for (std::size_t i = 0; i < angles.size(); ++i) {
    if (!std::isfinite(angles[i])) throw Error("an angle is not a number", path, "give a table of `plumbline angles`");
    AngleFigures& at = figures[angles[i]];
    ++at.pairs;
    at.failures += success[i] != 1;
    if (success[i] == 1) at.translation.push_back(translation[i]);
  }
  return figures;
}

void add_paper(Panel* panel) {
  const PaperAngles paper = paper_angles();
  for (const auto& [name, percent] : {std::pair("paper, original", paper.original), {"paper, with IMU", paper.imu}}) {
    Series series{
        .name = name, .mark = Mark::dashed, .color = name == std::string("paper, original") ? "#999999" : "#444444"};
    series.x.assign(paper.angles.begin(), paper.angles.end());
    series.y.assign(percent.begin(), percent.end());
    panel->series.push_back(series);
  }
}

}  // namespace

Plot frames_plot(const std::string& csv_path) {
  const CsvTable table = read_csv(csv_path);
  const std::vector<double> index = numbers(table, "index");
  const std::size_t status = table.column("status");
  std::vector<bool> tracked;
  Series lost{.name = "lost", .mark = Mark::points, .color = "#d62728", .width = 3};
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    tracked.push_back(table.rows[i][status] == "tracked");
    if (table.rows[i][status] != "lost") continue;
    lost.x.push_back(index[i]);
    lost.y.push_back(0);
  }
  const auto series = [&](const char* name, const char* column, double scale, bool all = false) {
    std::vector<double> values = numbers(table, column, scale);
    return Series{.name = name, .x = index, .y = all ? values : where(tracked, values), .width = 1.2};
  };
  const Axis frames{.label = "frame"};
  Plot plot{.columns = 1, .panel_width = 840, .panel_height = 260};
  plot.panels = {{.x = frames, .y = {.label = "matched pixels (%)", .low = 0}},
                 {.x = frames, .y = {.label = "mm", .low = 0}},
                 {.x = frames, .y = {.label = "seed to result (°)", .low = 0}},
                 {.x = frames, .y = {.label = "ms a frame", .low = 0}}};
  plot.panels[0].series = {series("matched", "inlier_fraction", 100), lost};
  plot.panels[1].series = {series("median distance", "median_distance_m", kMillimetres),
                           series("residual (rms)", "rms_m", kMillimetres)};
  plot.panels[2].series = {series("", "seed_to_result_deg", 1)};
  plot.panels[3].series = {series("whole frame", "total_ms", 1, true), series("registration", "track_ms", 1, true),
                           series("fusion", "integrate_ms", 1, true), series("ray cast", "raycast_ms", 1, true)};
  return plot;
}

Plot iterations_plot(const std::string& json_path) {
  const Iterations all = read_iterations(json_path);
  std::vector<int> levels;
  for (const Iteration& iteration : all.list)
    if (std::find(levels.begin(), levels.end(), iteration.level) == levels.end()) levels.push_back(iteration.level);
  Plot plot{.title = fmt::format("Frame {}", all.frame), .columns = 2, .panel_width = 560, .panel_height = 380};
  for (const int level : levels) plot.panels.push_back(level_panel(all, level));
  plot.panels.push_back(convergence_panel(all, levels));
  return plot;
}

Plot angles_plot(const std::vector<std::string>& csv_paths, const std::vector<std::string>& names, bool with_paper) {
  Plot plot{.columns = 2, .panel_width = 560, .panel_height = 420};
  plot.panels = {
      {.x = {.label = "angle between the frames (°)", .low = 0}, .y = {.label = "failures (%)", .low = 0, .high = 100}},
      {.x = {.label = "angle between the frames (°)", .low = 0},
       .y = {.label = "median error of the successes (mm)", .low = 0}}};
  for (std::size_t i = 0; i < csv_paths.size(); ++i) {
    Series failures{.name = names[i], .mark = Mark::line_points, .color = plot_color(i)}, errors = failures;
    for (const auto& [angle, figures] : read_angles(csv_paths[i])) {
      failures.x.push_back(angle);
      failures.y.push_back(100.0 * figures.failures / figures.pairs);
      errors.x.push_back(angle);
      errors.y.push_back(figures.translation.empty() ? kNothing
                                                     : kMillimetres * eval::statistics(figures.translation).median);
    }
    plot.panels[0].series.push_back(failures);
    plot.panels[1].series.push_back(errors);
  }
  if (with_paper) add_paper(&plot.panels[0]);
  return plot;
}

}  // namespace plumbline::app
