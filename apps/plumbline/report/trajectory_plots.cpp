#include "report/trajectory_plots.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <utility>

#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"

namespace plumbline::app {
namespace {

constexpr double kGap = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kTruthColor = "#222222";
constexpr const char* kDifferenceColor = "#e05050";
constexpr std::array<const char*, 3> kAxisNames = {"x (m)", "y (m)", "z (m)"};
constexpr double kStill = 10;  // seconds without a pose, over which no line is drawn

double seconds_since(const Trajectory& reference, Nanoseconds t) { return to_seconds(t - reference.front().time); }

void add(Series* series, double x, double y) {
  series->x.push_back(x);
  series->y.push_back(y);
}

void add(Series* series, const Eigen::Vector3d& p, ViewPlane plane) { add(series, p[plane.right], p[plane.up]); }

Series path(const std::string& name, const Trajectory& trajectory, const SE3& to_from_path, ViewPlane plane) {
  Series series{.name = name};
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    if (i > 0 && to_seconds(trajectory[i].time - trajectory[i - 1].time) > kStill) add(&series, kGap, kGap);
    add(&series, to_from_path * trajectory[i].world_from_camera.translation(), plane);
  }
  return series;
}

/// The part of the reference that lies between the first and the last pose that was compared.
Trajectory compared_part(const Trajectory& reference, const std::vector<EvaluatedTrajectory>& estimates) {
  if (estimates.empty()) return reference;
  Nanoseconds first = std::numeric_limits<Nanoseconds>::max(), last = std::numeric_limits<Nanoseconds>::min();
  for (const EvaluatedTrajectory& estimate : estimates) {
    first = std::min(first, reference[estimate.error->pairs.front().reference].time);
    last = std::max(last, reference[estimate.error->pairs.back().reference].time);
  }
  Trajectory part;
  std::copy_if(reference.begin(), reference.end(), std::back_inserter(part),
               [&](const StampedPose& pose) { return pose.time >= first && pose.time <= last; });
  return part;
}

/// Strokes from each estimated position to the true one.
Series differences(const Trajectory& reference, const EvaluatedTrajectory& estimate, ViewPlane plane) {
  constexpr std::size_t kMaxStrokes = kMaxPlotPoints / 4;
  Series series{.name = "difference", .color = kDifferenceColor, .width = 0.8};
  const auto& pairs = estimate.error->pairs;
  const std::size_t step = pairs.size() / kMaxStrokes + 1;
  for (std::size_t i = 0; i < pairs.size(); i += step) {
    const SE3& pose = (*estimate.estimate)[pairs[i].estimate].world_from_camera;
    add(&series, estimate.error->reference_from_estimate * pose.translation(), plane);
    add(&series, reference[pairs[i].reference].world_from_camera.translation(), plane);
    add(&series, kGap, kGap);
  }
  return series;
}

/// `value` of each pair over `time` of it, in order of time.
template <class Pairs, class Time, class Value>
Series over_time(const std::string& name, const Pairs& pairs, Time&& time, Value&& value) {
  std::vector<std::pair<double, double>> points;
  for (const auto& pair : pairs) points.emplace_back(time(pair), value(pair));
  std::sort(points.begin(), points.end());
  Series series{.name = name, .width = 1.2};
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i > 0 && points[i].first - points[i - 1].first > kStill) add(&series, kGap, kGap);
    add(&series, points[i].first, points[i].second);
  }
  return series;
}

}  // namespace

ViewPlane view_plane(const std::string& name, const Trajectory& trajectory) {
  for (const auto& [text, plane] : {std::pair<const char*, ViewPlane>{"xy", {0, 1}}, {"xz", {0, 2}}, {"yz", {1, 2}}})
    if (name == text) return plane;
  if (name != "auto") throw Error("there is no plane '" + name + "'", "view", "Choose xy, xz, yz or auto.");
  Eigen::Vector3d mean = Eigen::Vector3d::Zero(), spread = mean;
  for (const StampedPose& pose : trajectory)
    mean += pose.world_from_camera.translation() / static_cast<double>(trajectory.size());
  for (const StampedPose& pose : trajectory) spread += (pose.world_from_camera.translation() - mean).cwiseAbs2();
  int flat = 0;
  spread.minCoeff(&flat);
  return flat == 0 ? ViewPlane{1, 2} : flat == 1 ? ViewPlane{0, 2} : ViewPlane{0, 1};
}

Panel trajectory_panel(const Trajectory& reference, const std::vector<EvaluatedTrajectory>& estimates,
                       ViewPlane plane) {
  Panel panel{.x = {.label = kAxisNames[static_cast<std::size_t>(plane.right)]},
              .y = {.label = kAxisNames[static_cast<std::size_t>(plane.up)]},
              .equal_scale = true};
  if (estimates.size() == 1) panel.series.push_back(differences(reference, estimates.front(), plane));
  panel.series.push_back(path("truth", compared_part(reference, estimates), {}, plane));
  panel.series.back().color = kTruthColor;
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    panel.series.push_back(
        path(estimates[i].name, *estimates[i].estimate, estimates[i].error->reference_from_estimate, plane));
    panel.series.back().color = plot_color(i);
  }
  return panel;
}

Panel absolute_error_panel(const Trajectory& reference, const std::vector<EvaluatedTrajectory>& estimates) {
  Panel panel{.x = {.label = "time (s)"}, .y = {.label = "distance from the truth (m)", .low = 0}};
  for (const EvaluatedTrajectory& e : estimates)
    panel.series.push_back(over_time(
        e.name, e.error->pairs,
        [&](const auto& pair) { return seconds_since(reference, reference[pair.reference].time); },
        [](const auto& pair) { return pair.translation; }));
  return panel;
}

Plot absolute_error_plot(const Trajectory& reference, const std::vector<EvaluatedTrajectory>& estimates,
                         ViewPlane plane) {
  Plot plot{.columns = 2, .panel_width = 600, .panel_height = 480};
  plot.panels = {trajectory_panel(reference, estimates, plane), absolute_error_panel(reference, estimates)};
  return plot;
}

Plot relative_error_plot(const Trajectory& reference, const std::vector<RelativeTrajectory>& estimates) {
  Plot plot;
  plot.panels = {{.x = {.label = "time (s)"}, .y = {.label = "translation error (m)", .low = 0}},
                 {.x = {.label = "time (s)"}, .y = {.label = "rotation error (°)", .low = 0}}};
  for (const RelativeTrajectory& e : estimates) {
    const auto time = [&](const auto& pair) { return seconds_since(reference, reference[pair.reference_first].time); };
    plot.panels[0].series.push_back(
        over_time(e.name, e.error->pairs, time, [](const auto& pair) { return pair.translation; }));
    plot.panels[1].series.push_back(
        over_time(e.name, e.error->pairs, time, [](const auto& pair) { return degrees(pair.rotation); }));
  }
  return plot;
}

Plot path_plot(const std::string& name, const Trajectory& trajectory, ViewPlane plane) {
  Plot plot{.panel_width = 600, .panel_height = 480};
  plot.panels = {trajectory_panel(trajectory, {}, plane)};
  plot.panels[0].series[0].name = name;
  plot.panels[0].series[0].color = plot_color(0);
  return plot;
}

}  // namespace plumbline::app
