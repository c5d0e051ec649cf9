// Table "ATE and RPE metrics for our method compared to the original KinectFusion".
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lab/reproduce.h"

namespace plumbline::app {
namespace {

struct Column {
  const char* name;
  Setup setup;
};
/// The first three are the paper's.
const std::vector<Column>& columns() {
  static const std::vector<Column> list = {{"Orig.", {"kinectfusion", "none"}},
                                           {"IMU", {"paper", "ideal"}},
                                           {"+noise", {"paper", "bno055"}},
                                           {"plumbline, no IMU", {"plumbline", "none"}},
                                           {"plumbline, IMU", {"plumbline", "ideal"}},
                                           {"plumbline, +noise", {"plumbline", "bno055"}}};
  return list;
}
constexpr std::size_t kPapers = 3;

/// Of one dataset and one column, over the seeds.
struct AteResults {
  std::vector<std::optional<RunFigures>> runs;

  std::vector<std::optional<double>> values(std::optional<double> RunFigures::*figure) const {
    std::vector<std::optional<double>> list;
    for (const auto& run : runs) list.push_back(run ? (*run).*figure : std::nullopt);
    return list;
  }
  std::optional<double> mean(std::optional<double> RunFigures::*figure) const {
    return mean_if_complete(values(figure));
  }
  std::optional<double> mean_lost() const {
    std::vector<std::optional<double>> lost;
    for (const auto& run : runs) lost.push_back(run ? std::optional<double>(run->lost) : std::nullopt);
    return mean_if_complete(lost);
  }
};
using Rows = std::vector<std::vector<AteResults>>;  // by dataset and column

Rows find(const ReproduceOptions& options, const std::vector<DatasetSource>& sources) {
  Rows rows;
  for (const DatasetSource& source : sources) {
    rows.emplace_back();
    for (const Column& column : columns()) {
      AteResults found;
      for (const int seed : seeds_of(column.setup.sensor, options.seeds))
        found.runs.push_back(figures_if_finished(run_of(options, source, column.setup, seed, options.frames)));
      rows.back().push_back(found);
    }
  }
  return rows;
}

using Figure = std::optional<double> RunFigures::*;

struct Comparison {
  std::optional<double> mean, baseline;       ///< over the datasets that have both
  std::optional<double> of_means, of_ratios;  ///< %
  std::size_t datasets = 0;
};

Comparison compare(const Rows& rows, std::size_t column, Figure figure) {
  std::vector<double> mine, theirs, ratios;
  for (const auto& row : rows) {
    const auto value = row[column].mean(figure), before = row[0].mean(figure);
    if (!value || !before || *before <= 0) continue;
    mine.push_back(*value);
    theirs.push_back(*before);
    ratios.push_back(*value / *before);
  }
  if (mine.empty()) return {};
  const double mean = *mean_of(mine), baseline = *mean_of(theirs);
  return {mean, baseline, 100 * (mean / baseline - 1), 100 * (*mean_of(ratios) - 1), mine.size()};
}

void add_averages(Table* table, const Rows& rows, const std::vector<Figure>& figures) {
  // Of the paper: ATE, then RPE.
  constexpr double kPaperMean[2][kPapers] = {{0.664843727272727, 0.219829545454545, 0.309310636363636},
                                             {0.621532545454545, 0.477241636363636, 0.493541727272727}};
  std::vector<Cell> average = {"AVG"}, of_means = {"Improv. (ratio of means)"},
                    of_ratios = {"Improv. (mean of ratios)"};
  for (std::size_t f = 0; f < figures.size(); ++f) {
    std::vector<double> paper_ratios[kPapers];
    for (const PaperDataset& dataset : paper_datasets())
      for (std::size_t c = 0; c < kPapers; ++c)
        paper_ratios[c].push_back(f == 0 ? dataset.ate[c] / dataset.ate[0] : dataset.rpe[c] / dataset.rpe[0]);
    for (std::size_t c = 0; c < kPapers; ++c) {
      const Comparison found = compare(rows, c, figures[f]);
      const double paper = kPaperMean[f][c];
      average.insert(average.end(), {number_or_dash(found.mean, 3), Cell(paper, 3)});
      if (c == 0) {
        of_means.insert(of_means.end(), {"–", "–"});
        of_ratios.insert(of_ratios.end(), {"–", "–"});
        continue;
      }
      of_means.insert(of_means.end(),
                      {number_or_dash(found.of_means, 0, "%"), Cell(100 * (paper / kPaperMean[f][0] - 1), 0, "%")});
      of_ratios.insert(of_ratios.end(),
                       {number_or_dash(found.of_ratios, 0, "%"), Cell(100 * (*mean_of(paper_ratios[c]) - 1), 0, "%")});
    }
  }
  table->rows.insert(table->rows.end(), {average, of_means, of_ratios});
}

std::string frames_text(const ReproduceOptions& options) {
  return options.frames > 0 ? fmt::format("the first {} frames of each sequence", options.frames)
                            : "all frames of each sequence";
}

Table papers_table(const ReproduceOptions& options, const std::vector<DatasetSource>& sources, const Rows& rows) {
  Table table;
  table.name = "ate";
  table.title =
      "ATE and RPE (RMSE, m), the published method against the original (paper: table \"ATE and RPE metrics\")";
  table.columns = {"dataset"};
  const std::vector<Figure> figures = {&RunFigures::ate_all, &RunFigures::rpe};
  for (const char* error : {"ATE", "RPE"})
    for (std::size_t c = 0; c < kPapers; ++c)
      table.columns.insert(table.columns.end(), {fmt::format("{} {}", error, columns()[c].name),
                                                 fmt::format("paper {} {}", error, columns()[c].name)});
  for (std::size_t i = 0; i < sources.size(); ++i) {
    std::vector<Cell> cells = {sources[i].name};
    for (std::size_t f = 0; f < figures.size(); ++f)
      for (std::size_t c = 0; c < kPapers; ++c) {
        cells.push_back(number_or_dash(rows[i][c].mean(figures[f]), 3));
        cells.emplace_back(f == 0 ? sources[i].paper->ate[c] : sources[i].paper->rpe[c], 3);
      }
    table.rows.push_back(cells);
  }
  add_averages(&table, rows, figures);
  table.notes = {
      fmt::format(
          "Here: {}; presets `kinectfusion` and `paper` in a volume of 6 m; +noise: the error model of a BNO055, mean "
          "of "
          "seeds 1 to {}; all frames count, a lost one with the previous accepted pose; RPE over 1 s. AVG and "
          "Improv. over the datasets where all runs came to their end; of the paper: all eleven, whole.",
          frames_text(options), options.seeds),
      "Datasets with a scene in brackets are the recorded path of the hand through a simulated scene: compare their "
      "ratios with the paper's, not their metres. The paper's RPE is not in the units its caption says (0.47 m on "
      "fr1/xyz "
      "beside an ATE of 0.022 m)."};
  return table;
}

Cell ate_cell(const AteResults& found) {
  const auto mean = found.mean(&RunFigures::ate_all);
  if (!mean) return {"–"};
  double worst = 0;
  for (const auto& value : found.values(&RunFigures::ate_all)) worst = std::max(worst, *value);
  Cell cell(*mean, 4);
  if (found.runs.size() > 1) cell.text += fmt::format(", worst {:.4f}", worst);
  if (const double lost = found.mean_lost().value_or(0); lost > 0) cell.text += fmt::format(" ({:.3g} lost)", lost);
  return cell;
}

Table presets_table(const ReproduceOptions& options, const std::vector<DatasetSource>& sources, const Rows& rows) {
  Table table;
  table.name = "ate_presets";
  table.title = "ATE of all frames (RMSE, m) with the worst seed and the frames lost, all presets";
  table.columns = {"dataset", "frames"};
  for (const Column& column : columns()) table.columns.emplace_back(column.name);
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const auto& first = rows[i][0].runs[0];
    table.rows.push_back({sources[i].name, first ? Cell(first->frames, 0) : Cell("–")});
    for (const AteResults& found : rows[i]) table.rows.back().push_back(ate_cell(found));
  }
  for (const auto& [name, figure] : {std::pair("Improv. (ratio of means)", &Comparison::of_means),
                                     std::pair("Improv. (mean of ratios)", &Comparison::of_ratios)}) {
    table.rows.push_back({name, "–", "–"});
    for (std::size_t c = 1; c < columns().size(); ++c)
      table.rows.back().push_back(number_or_dash(compare(rows, c, &RunFigures::ate_all).*figure, 0, "%"));
  }
  table.notes = {"`plumbline` in its own volume of 8 m. Here: " + frames_text(options) + "."};
  return table;
}

/// The paper's RPE is in no known unit: over a second, and over all pairs of poses, which may be what it is.
Table rpe_table(const std::vector<DatasetSource>& sources, const Rows& rows) {
  Table table;
  table.name = "ate_rpe";
  table.title = "RPE of all frames (RMSE, m), over 1 s / over all pairs of poses";
  table.columns = {"dataset"};
  for (const Column& column : columns())
    table.columns.insert(table.columns.end(),
                         {fmt::format("{}: 1 s", column.name), fmt::format("{}: all pairs", column.name)});
  for (std::size_t i = 0; i < sources.size(); ++i) {
    table.rows.push_back({sources[i].name});
    for (const AteResults& found : rows[i])
      for (const Figure figure : {&RunFigures::rpe, &RunFigures::rpe_all_pairs})
        table.rows.back().push_back(number_or_dash(found.mean(figure), 4));
  }
  return table;
}

/// A group of bars for each dataset.
Plot plot_of(const std::vector<DatasetSource>& sources, const Rows& rows) {
  Plot plot{.title = "ATE of all frames", .panels = {Panel{}}};
  Panel& panel = plot.panels[0];
  panel.x = {.low = -0.7, .high = static_cast<double>(sources.size()) - 0.3};
  panel.y = {.label = "ATE RMSE (m)", .low = 0};
  for (std::size_t i = 0; i < sources.size(); ++i) panel.x.ticks.emplace_back(i, sources[i].name);
  for (std::size_t c = 0; c < columns().size(); ++c) {
    Series series{columns()[c].name, {}, {}, Mark::bars};
    for (std::size_t i = 0; i < sources.size(); ++i) {
      series.x.push_back(static_cast<double>(i));
      series.y.push_back(rows[i][c].mean(&RunFigures::ate_all).value_or(std::nan("")));
    }
    panel.series.push_back(series);
  }
  plot.panel_width = std::max(720, static_cast<int>(160 * sources.size()));
  return plot;
}

/// The data sets at every stride.
std::vector<DatasetSource> thinned_sources(const ReproduceOptions& options) {
  std::vector<DatasetSource> sources;
  for (const DatasetSource& source : dataset_sources(options, options.frames))
    for (const int stride : options.strides) sources.push_back(thinned(source, stride));
  return sources;
}

}  // namespace

Plan plan_ate(const ReproduceOptions& options) {
  const std::vector<DatasetSource> sources = thinned_sources(options);
  Plan plan;
  for (const DatasetSource& source : sources) {
    if (source.simulate) plan.sequences.push_back(*source.simulate);
    for (const Column& column : columns())
      for (const int seed : seeds_of(column.setup.sensor, options.seeds))
        plan.runs.push_back(run_of(options, source, column.setup, seed, options.frames));
  }
  plan.result = [options, sources] {
    const Rows rows = find(options, sources);
    return ReproduceResult{
        {papers_table(options, sources, rows), presets_table(options, sources, rows), rpe_table(sources, rows)},
        {{"ate", plot_of(sources, rows)}}};
  };
  return plan;
}

}  // namespace plumbline::app
