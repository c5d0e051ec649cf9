// Table "Comparison of the average RMSE Absolute Trajectory Error … using different regularizations parameter λ".
#include <fmt/format.h>

#include <array>

#include "lab/reproduce.h"
#include "plumbline/trajectory.h"

namespace plumbline::app {
namespace {

constexpr std::array<const char*, 5> kFactors = {"0.05", "0.20", "1.00", "2.00", "5.00"};
constexpr std::size_t kSchedules = 5;

struct Schedule {
  const char *name, *value;     // in the paper, of orientation.schedule
  std::array<double, 6> paper;  // improvement in %, for each factor, and its mean
};
constexpr std::array<Schedule, kSchedules> kRows = {{
    {"c", "constant", {-29.91568789, 4.661220689, -28.93852639, -33.31487678, -43.68989455, -26.23955298}},
    {"c/√n", "inverse_sqrt", {-26.2291526, -31.29484938, -32.84374016, -46.45088418, -45.51304094, -36.46633345}},
    {"c/n", "inverse", {-6.340281355, -10.59902937, -51.00013569, -40.78152209, -28.89552197, -27.5232981}},
    {"c/n²", "inverse_square", {20.30534096, -2.287778634, -44.63362218, -33.89520116, -40.56914402, -20.216081}},
    {"−c ln(n)", "negative_log", {72.06227272, -32.10671921, -16.14736686, -33.67480673, -41.12075834, -10.19747569}},
}};
constexpr std::array<double, 6> kPaperMeans = {5.976498366,  -14.32543118, -34.71267826,
                                               -37.62345819, -39.95767196, -24.12854824};

const Setup kBaseline{"kinectfusion", "none"};

Setup setup_of(const Schedule& schedule, const char* factor, const std::string& sensor) {
  return {"paper",
          sensor,
          {std::string("orientation.schedule=") + schedule.value, std::string("orientation.lambda=") + factor},
          fmt::format("{}-{}", schedule.value, factor)};
}

/// ATE over all frames, the mean over the seeds; none if a run is missing.
std::optional<double> ate(const ReproduceOptions& options, const DatasetSource& source, const Setup& setup) {
  std::vector<std::optional<double>> values;
  for (const int seed : seeds_of(setup.sensor, options.seeds)) {
    const auto figures = figures_if_finished(run_of(options, source, setup, seed, options.frames));
    values.push_back(figures ? figures->ate_all : std::nullopt);
  }
  return mean_if_complete(values);
}

struct Improvement {
  std::optional<double> of_means, of_ratios;  // %
  std::optional<double> ate;                  // metres, mean over the datasets
};

/// Over the datasets whose baseline came to its end; none if one of them lacks the other.
Improvement improvement(const ReproduceOptions& options, const std::vector<DatasetSource>& sources,
                        const Setup& setup) {
  double ours = 0, baseline = 0, ratios = 0;
  int count = 0;
  for (const DatasetSource& source : sources) {
    const auto before = ate(options, source, kBaseline);
    if (!before) continue;
    const auto after = ate(options, source, setup);
    if (!after) return {};
    ours += *after;
    baseline += *before;
    ratios += *after / *before;
    ++count;
  }
  if (count == 0) return {};
  return {100 * (ours / baseline - 1), 100 * (ratios / count - 1), ours / count};
}

using ImprovementGrid = std::array<std::array<Improvement, kFactors.size()>, kSchedules>;

/// The paper's layout: a row for each schedule, a column for each factor and the mean, the paper's figure beside each.
Table table_of(const ImprovementGrid& grid, std::optional<double> Improvement::*figure, const std::string& name,
               const std::string& title) {
  Table table{.name = name, .title = title, .notes = {}, .columns = {"c ="}, .rows = {}};
  for (const char* factor : kFactors)
    table.columns.insert(table.columns.end(), {factor, fmt::format("paper {}", factor)});
  table.columns.insert(table.columns.end(), {"AVG", "paper AVG"});
  const auto add = [&](const char* row, const std::vector<std::optional<double>>& ours,
                       const std::array<double, 6>& paper) {
    std::vector<Cell> cells = {row};
    for (std::size_t i = 0; i < ours.size(); ++i) {
      cells.push_back(number_or_dash(ours[i], 0, "%"));
      cells.emplace_back(paper[i], 0, "%");
    }
    table.rows.push_back(cells);
  };
  for (std::size_t row = 0; row < kSchedules; ++row) {
    std::vector<std::optional<double>> ours;
    for (const Improvement& cell : grid[row]) ours.push_back(cell.*figure);
    ours.push_back(mean_if_complete(ours));
    add(kRows[row].name, ours, kRows[row].paper);
  }
  std::vector<std::optional<double>> means;
  for (std::size_t column = 0; column < kFactors.size(); ++column) {
    std::vector<std::optional<double>> values;
    for (const auto& row : grid) values.push_back(row[column].*figure);
    means.push_back(mean_if_complete(values));
  }
  means.push_back(mean_if_complete(means));
  add("AVG", means, kPaperMeans);
  return table;
}

/// The metres behind it.
Table ate_table(const ImprovementGrid& grid, const std::optional<double>& baseline, const std::string& name) {
  Table table{.name = name, .title = "The same, mean ATE (RMSE, m)", .notes = {}, .columns = {"c ="}, .rows = {}};
  table.columns.insert(table.columns.end(), kFactors.begin(), kFactors.end());
  for (std::size_t row = 0; row < kSchedules; ++row) {
    table.rows.push_back({kRows[row].name});
    for (const Improvement& cell : grid[row]) table.rows.back().push_back(number_or_dash(cell.ate, 4));
  }
  if (baseline) table.notes = {fmt::format("The original has {:.4f} m.", *baseline)};
  return table;
}

/// Of the datasets where it came to its end.
std::optional<double> baseline_ate(const ReproduceOptions& options, const std::vector<DatasetSource>& sources) {
  std::vector<double> values;
  for (const DatasetSource& source : sources)
    if (const auto value = ate(options, source, kBaseline)) values.push_back(*value);
  return mean_of(values);
}

/// Improvement over the factor, a line for each schedule, ours and the paper's side by side.
Plot plot_of(const ImprovementGrid& grid, const std::string& sensor) {
  Plot plot{.title = "ATE against the original over the factor c", .panels = {}, .columns = 2};
  Panel ours{.title = "Plumbline, preset paper, " + sensor}, paper{.title = "paper"};
  for (Panel* panel : {&ours, &paper}) {
    panel->x = {.label = "c", .low = 0.04, .high = 6, .log = true};
    panel->y = {.label = "change of ATE (%)"};
  }
  for (std::size_t row = 0; row < kSchedules; ++row) {
    Series mine{kRows[row].name, {}, {}, Mark::line_points}, theirs = mine;
    for (std::size_t i = 0; i < kFactors.size(); ++i) {
      const double factor = std::stod(kFactors[i]);
      theirs.x.push_back(factor);
      theirs.y.push_back(kRows[row].paper[i]);
      if (!grid[row][i].of_means) continue;
      mine.x.push_back(factor);
      mine.y.push_back(*grid[row][i].of_means);
    }
    ours.series.push_back(mine);
    paper.series.push_back(theirs);
  }
  plot.panels = {ours, paper};
  plot.panel_width = 560;
  return plot;
}

ReproduceResult lambda_result(const ReproduceOptions& options, const std::vector<DatasetSource>& sources) {
  ReproduceResult result;
  std::vector<std::string> names;
  for (const DatasetSource& source : sources) names.push_back(source.name);
  for (const std::string& sensor : options.sensors) {
    ImprovementGrid grid;
    for (std::size_t row = 0; row < kSchedules; ++row)
      for (std::size_t i = 0; i < kFactors.size(); ++i)
        grid[row][i] = improvement(options, sources, setup_of(kRows[row], kFactors[i], sensor));
    const std::string with = sensor == "ideal" ? "ideal IMU" : "IMU with its error";
    result.tables.push_back(table_of(grid, &Improvement::of_means, "lambda_" + sensor,
                                     "Change of the ATE against the original for λ, " + with + ": ratio of means"));
    result.tables.back().notes = {
        fmt::format("Preset `paper` against `kinectfusion`, both in a volume of 6 m; ATE RMSE of all frames, where a "
                    "lost one counts with "
                    "the previous accepted pose. n is the matched fraction. Over {}; {} frames of each{}. The "
                    "paper does not say which "
                    "of the two means it has.",
                    fmt::join(names, ", "), options.frames > 0 ? fmt::format("the first {}", options.frames) : "all",
                    sensor == "ideal" ? "" : fmt::format("; mean of seeds 1 to {}", options.seeds))};
    result.tables.push_back(table_of(grid, &Improvement::of_ratios, "lambda_" + sensor + "_ratios",
                                     "The same, mean of the datasets' ratios"));
    result.tables.push_back(ate_table(grid, baseline_ate(options, sources), "lambda_" + sensor + "_ate"));
    result.plots.emplace_back("lambda_" + sensor, plot_of(grid, with));
  }
  return result;
}

}  // namespace

Plan plan_lambda(const ReproduceOptions& options) {
  const std::vector<DatasetSource> sources = dataset_sources(options, options.frames);
  Plan plan;
  for (const DatasetSource& source : sources) {
    if (source.simulate) plan.sequences.push_back(*source.simulate);
    plan.runs.push_back(run_of(options, source, kBaseline, 1, options.frames));
    for (const std::string& sensor : options.sensors)
      for (const Schedule& schedule : kRows)
        for (const char* factor : kFactors)
          for (const int seed : seeds_of(sensor, options.seeds))
            plan.runs.push_back(run_of(options, source, setup_of(schedule, factor, sensor), seed, options.frames));
  }
  plan.result = [options, sources] { return lambda_result(options, sources); };
  return plan;
}

}  // namespace plumbline::app
