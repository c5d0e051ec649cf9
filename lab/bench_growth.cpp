#include "lab/bench_growth.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "lab/run_times.h"
#include "lab/stages.h"

namespace plumbline::app {
namespace {

constexpr int kWarmUp = 8;

/// Times of one size become a column.
void add(const StageFrames& frames, const Parameters& parameters, const std::string& backend, int threads,
         double seconds, Growth* growth) {
  const std::vector<std::string> names = {"preprocess", "track", "integrate", "ray cast", "a frame"};
  const StageTimes ms = run_stage_times(frames, parameters, backend, threads, 4 * seconds);
  const std::vector<double> column = {ms.preprocess, ms.track, ms.integrate, ms.raycast, ms.total()};
  if (growth->stages.empty()) {
    growth->stages = names;
    growth->milliseconds.resize(names.size());
  }
  for (std::size_t i = 0; i < column.size(); ++i) growth->milliseconds[i].push_back(column[i]);
}

Growth over_images(const Parameters& parameters, const std::string& backend, double seconds) {
  Growth growth{"image", "Time over the image's size (ms, one thread)", "pixels", {}, {}, {}, {}};
  for (const int width : {160, 320, 640, 1280}) {
    const int height = width * 3 / 4;
    growth.sizes.push_back(static_cast<double>(width) * height);
    growth.points.push_back(fmt::format("{}x{}", width, height));
    add(simulated_frames(width, height, kWarmUp), parameters, backend, 1, seconds, &growth);
  }
  return growth;
}

Growth over_volumes(const StageFrames& frames, Parameters parameters, const std::string& backend, double seconds) {
  Growth growth{"volume", "Time over the volume's resolution (ms, one thread)", "voxels", {}, {}, {}, {}};
  for (const int resolution : {128, 256, 384, 512, 768}) {
    parameters.volume.resolution = resolution;
    growth.sizes.push_back(std::pow(resolution, 3));
    growth.points.push_back(fmt::format("{}^3", resolution));
    add(frames, parameters, backend, 1, seconds, &growth);
  }
  return growth;
}

Growth over_threads(const StageFrames& frames, const Parameters& parameters, const std::string& backend, int threads,
                    double seconds) {
  Growth growth{"threads", "Time over the number of threads (ms)", "threads", {}, {}, {}, {}};
  for (int n = 1;; n = std::min(2 * n, threads)) {
    growth.sizes.push_back(n);
    growth.points.push_back(std::to_string(n));
    add(frames, parameters, backend, n, seconds, &growth);
    if (n >= threads) return growth;
  }
}

}  // namespace

std::vector<Growth> measure_growth(const Parameters& parameters, const std::string& backend, int threads,
                                   double seconds) {
  const StageFrames frames = simulated_frames(640, 480, kWarmUp);
  return {over_images(parameters, backend, seconds), over_volumes(frames, parameters, backend, seconds),
          over_threads(frames, parameters, backend, threads, seconds)};
}

double exponent(const std::vector<double>& sizes, const std::vector<double>& milliseconds) {
  double mean_x = 0, mean_y = 0, xx = 0, xy = 0;
  const auto count = static_cast<double>(sizes.size());
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    mean_x += std::log(sizes[i]) / count;
    mean_y += std::log(milliseconds[i]) / count;
  }
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const double x = std::log(sizes[i]) - mean_x;
    xx += x * x;
    xy += x * (std::log(milliseconds[i]) - mean_y);
  }
  return xx > 0 ? xy / xx : 0;
}

Table growth_table(const Growth& growth) {
  Table table{.name = "growth_" + growth.name,
              .title = growth.title,
              .notes = {fmt::format("Grows as ({})^exponent, a least-squares fit; the simulated desk.", growth.label)},
              .columns = {"stage"},
              .rows = {}};
  table.columns.insert(table.columns.end(), growth.points.begin(), growth.points.end());
  table.columns.emplace_back("exponent");
  for (std::size_t i = 0; i < growth.stages.size(); ++i) {
    std::vector<Cell> row = {growth.stages[i]};
    for (const double ms : growth.milliseconds[i]) row.emplace_back(ms, 2);
    row.push_back(growth.sizes.size() > 1 ? Cell(exponent(growth.sizes, growth.milliseconds[i]), 2) : Cell("–"));
    table.rows.push_back(std::move(row));
  }
  return table;
}

Plot growth_plot(const std::vector<Growth>& growths) {
  Plot plot{.title = "How the time of a frame grows", .columns = static_cast<int>(growths.size()), .panel_width = 460};
  for (const Growth& growth : growths) {
    constexpr double kMargin = 1.4;
    Panel panel{.title = growth.title,
                .x = {.label = growth.label,
                      .low = growth.sizes.front() / kMargin,
                      .high = growth.sizes.back() * kMargin,
                      .log = true},
                .y = {.label = "time of a frame (ms)", .log = true}};
    for (std::size_t p = 0; p < growth.sizes.size(); ++p) panel.x.ticks.emplace_back(growth.sizes[p], growth.points[p]);
    for (std::size_t i = 0; i < growth.stages.size(); ++i)
      panel.series.push_back(
          {.name = growth.stages[i], .x = growth.sizes, .y = growth.milliseconds[i], .mark = Mark::line_points});
    plot.panels.push_back(std::move(panel));
  }
  return plot;
}

}  // namespace plumbline::app
