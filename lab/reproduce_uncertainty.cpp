// Figure "Uncertainty characterization of the BNO055 IMU": the study on a turntable, with the simulated sensor on it.
//
// After the Guide to the Expression of Uncertainty in Measurement (JCGM 100:2008), docs/method.md §5: at each reference
// orientation the sensor rests for 5 s, then 1000 readings are taken at 100 Hz. The standard deviation of the readings
// is the random part, the difference of their mean from the reference the systematic one.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "lab/reproduce.h"
#include "plumbline/angles.h"
#include "plumbline/se3.h"
#include "plumbline/statistics.h"
#include "plumbline/time.h"
#include "sensor/error_model.h"
#include "sim/orientation_sensor.h"

namespace plumbline::app {
namespace {

constexpr std::array<const char*, 3> kAxes = {"X", "Y", "Z"};
constexpr std::array<double, 3> kPaper = {3, 3, 10};  // largest systematic error, degrees
constexpr int kStep = 5, kReadings = 1000;            // degrees; at each orientation
constexpr double kRest = 5;                           // seconds
constexpr double kCoverage = 2;                       // k of the expanded uncertainty: about 95 %

struct Characteristic {
  std::vector<double> angle, systematic, random;  // degrees; angle −180 to 180
};

sim::OrientationSensorOptions chip(int seed) {
  const Eigen::Vector3d amplitude = error_model("bno055").amplitude;
  sim::OrientationSensorOptions options;
  options.tilt_error = amplitude.x();
  options.heading_error = amplitude.z();
  options.seed = static_cast<std::uint64_t>(seed);
  return options;
}

/// What the arm does at one orientation: readings of the error about the axis, degrees.
std::vector<double> readings(const Eigen::Matrix3d& reference, int axis, const sim::OrientationSensorOptions& options) {
  const double duration = kRest + kReadings / options.rate;
  const SE3 pose(reference, Eigen::Vector3d::Zero());
  std::vector<double> errors;
  for (const sim::InertialSample& sample : sim::simulate_sensor([&](double) { return pose; }, duration, 0, options)) {
    if (to_seconds(sample.time) < kRest || errors.size() == kReadings) continue;
    const Eigen::Matrix3d difference = sample.earth_from_body * reference.transpose();
    errors.push_back(degrees(so3::log(difference)[axis]));
  }
  return errors;
}

Characteristic characterise(int axis, int seed) {
  Characteristic result;
  const sim::OrientationSensorOptions options = chip(seed);
  for (int degrees = -180; degrees <= 180; degrees += kStep) {
    const Eigen::Matrix3d reference = so3::exp(Eigen::Vector3d(Eigen::Vector3d::Unit(axis) * radians(degrees)));
    const eval::Statistics errors = eval::statistics(readings(reference, axis, options));
    result.angle.push_back(degrees);
    result.systematic.push_back(errors.mean);
    result.random.push_back(errors.std);
  }
  return result;
}

double largest(const std::vector<double>& values) {
  double result = 0;
  for (const double value : values) result = std::max(result, std::abs(value));
  return result;
}

/// Root mean square over the reference orientations: the standard uncertainty of a reading at an unknown one.
double standard(const Characteristic& c) {
  double sum = 0;
  for (std::size_t i = 0; i < c.angle.size(); ++i) sum += c.systematic[i] * c.systematic[i] + c.random[i] * c.random[i];
  return std::sqrt(sum / static_cast<double>(c.angle.size()));
}

using Study = std::vector<std::array<Characteristic, 3>>;  // by seed and axis

Table summary(const Study& study) {
  Table table;
  table.name = "uncertainty";
  table.title =
      "Uncertainty of the orientation sensor (paper: figure \"Uncertainty characterization of the BNO055 IMU\")";
  table.columns = {"seed",
                   "axis",
                   "systematic, largest",
                   "paper systematic",
                   "random, largest",
                   "paper random",
                   "combined standard",
                   "expanded (k = 2)"};
  for (std::size_t seed = 0; seed < study.size(); ++seed)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Characteristic& c = study[seed][axis];
      const double u = standard(c);
      table.rows.push_back({Cell(static_cast<double>(seed + 1), 0), kAxes[axis], Cell(largest(c.systematic), 2, "°"),
                            Cell(kPaper[axis], 0, "°"), Cell(largest(c.random), 3, "°"), Cell(0, 0, "°"),
                            Cell(u, 2, "°"), Cell(kCoverage * u, 2, "°")});
    }
  table.notes = {fmt::format(
      "The simulated sensor (`plumbline simulate`, error model bno055) at steps of {}° over ±180° about each axis of "
      "the earth "
      "(Z up), {} readings at each after {} s of rest. The error model is drawn from a seed and scaled to the paper's "
      "amplitudes; "
      "as the paper found, there is no random part. Combined: root mean square of systematic and random part over all "
      "orientations.",
      kStep, kReadings, kRest)};
  return table;
}

Table points(const Study& study) {
  Table table;
  table.name = "uncertainty_points";
  table.title = "The same, at each orientation";
  table.columns = {"seed", "axis", "angle_deg", "systematic_deg", "random_deg"};
  for (std::size_t seed = 0; seed < study.size(); ++seed)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Characteristic& c = study[seed][axis];
      for (std::size_t i = 0; i < c.angle.size(); ++i)
        table.rows.push_back({Cell(static_cast<double>(seed + 1), 0), kAxes[axis], Cell(c.angle[i], 0),
                              Cell(c.systematic[i], 4), Cell(c.random[i], 5)});
    }
  return table;
}

/// As the paper: the axes side by side, systematic above random.
Plot plot_of(const Study& study) {
  Plot plot{.title = "Uncertainty of the simulated BNO055", .panels = {}, .columns = 3};
  plot.panel_width = 380;
  plot.panel_height = 260;
  for (const bool systematic : {true, false})
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Panel panel{.title = fmt::format("{}, {}", kAxes[axis], systematic ? "systematic" : "random")};
      panel.x = {.label = "angle (°)", .low = -180, .high = 180};
      for (const int tick : {-180, -90, 0, 90, 180}) panel.x.ticks.emplace_back(tick, std::to_string(tick));
      panel.y = {.label = "error (°)"};
      if (!systematic) panel.y = {.label = "error (°)", .low = 0, .high = 0.1};
      for (std::size_t seed = 0; seed < study.size(); ++seed) {
        const Characteristic& c = study[seed][axis];
        panel.series.push_back(
            {fmt::format("seed {}", seed + 1), c.angle, systematic ? c.systematic : c.random, Mark::line});
      }
      plot.panels.push_back(panel);
    }
  return plot;
}

ReproduceResult uncertainty_result(const ReproduceOptions& options) {
  Study study;
  for (int seed = 1; seed <= options.seeds; ++seed)
    study.push_back({characterise(0, seed), characterise(1, seed), characterise(2, seed)});
  return {{summary(study), points(study)}, {{"uncertainty", plot_of(study)}}};
}

}  // namespace

Plan plan_uncertainty(const ReproduceOptions& options) {
  Plan plan;
  plan.result = [options] { return uncertainty_result(options); };
  return plan;
}

}  // namespace plumbline::app
