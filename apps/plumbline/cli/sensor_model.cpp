#include "cli/sensor_model.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <vector>

#include "io/atomic_file.h"
#include "io/text_file.h"
#include "plumbline/angles.h"
#include "plumbline/error.h"

namespace plumbline::app {
namespace {

constexpr const char* kModelAdvice = "make the file with `plumbline characterise`";
constexpr const char* kAxes[] = {"east", "north", "up"};

std::string list(const std::vector<double>& radians, double unit = kDegreesPerRadian) {
  std::vector<std::string> words;
  for (const double value : radians) words.push_back(fmt::format("{:.9g}", unit * value));
  // An integer would be of another type in TOML.
  for (std::string& word : words)
    if (word.find_first_of(".en") == std::string::npos) word += ".0";
  return fmt::format("[{}]", fmt::join(words, ", "));
}

std::string axis_toml(const char* name, const AxisStudy& axis) {
  std::vector<double> sine, cosine;
  for (std::size_t i = 0; i + 1 < axis.fit.coefficients.size(); i += 2) {
    sine.push_back(axis.fit.coefficients[i]);
    cosine.push_back(axis.fit.coefficients[i + 1]);
  }
  return fmt::format(
      "\n[{}]  # error about this axis over the angle about it, {} angles\namplitude_deg = {:.9f}\n"
      "random_deg = {:.9f}\nconstant_deg = {:.9f}\nsine_deg = {}\ncosine_deg = {}\n",
      name, axis.rests.size(), degrees(axis.amplitude), degrees(axis.random), degrees(axis.fit.constant), list(sine),
      list(cosine));
}

std::vector<double> numbers(const toml::table& table, const std::string& key, const std::string& path) {
  std::vector<double> values;
  const toml::array* array = table.at_path(key).as_array();
  if (array == nullptr) throw Error("has no list '" + key + "'", path, kModelAdvice);
  for (const toml::node& node : *array) {
    const auto value = node.value<double>();
    if (!value || !std::isfinite(*value)) throw Error("'" + key + "' holds what is not a number", path, kModelAdvice);
    values.push_back(*value);
  }
  return values;
}

double number(const toml::table& table, const std::string& key, const std::string& path) {
  const auto value = table.at_path(key).value<double>();
  if (!value || !std::isfinite(*value)) throw Error("has no number '" + key + "'", path, kModelAdvice);
  return *value;
}

PeriodicError read_axis(const toml::table& table, const std::string& name, const std::string& path) {
  PeriodicError error;
  error.constant = radians(number(table, name + ".constant_deg", path));
  const std::vector<double> sine = numbers(table, name + ".sine_deg", path),
                            cosine = numbers(table, name + ".cosine_deg", path);
  if (sine.size() != cosine.size()) throw Error("'" + name + "' has lists of different lengths", path, kModelAdvice);
  for (std::size_t i = 0; i < sine.size(); ++i)
    error.coefficients.insert(error.coefficients.end(), {radians(sine[i]), radians(cosine[i])});
  return error;
}

toml::table parse(const std::string& path) {
  const std::string text = read_file(path);
  try {
    return toml::parse(text);
  } catch (const toml::parse_error& error) {
    throw Error(std::string(error.description()), fmt::format("{}:{}", path, error.source().begin.line), kModelAdvice);
  }
}

}  // namespace

void write_sensor_model(const std::string& path, const Characterisation& study) {
  const Eigen::Matrix3d covariance = study.covariance();
  const std::vector<double> entries(covariance.data(), covariance.data() + 9);
  std::string text =
      "# An orientation sensor, as `plumbline characterise` found it. For `plumbline run --imu-model` and "
      "`--sensor-model`.\n# Combined uncertainty (k = 1) about the earth's axes (east, north, up), row by row.\n";
  text += fmt::format("covariance_deg2 = {}\n", list(entries, kDegreesPerRadian * kDegreesPerRadian));
  for (std::size_t axis = 0; axis < 3; ++axis) text += axis_toml(kAxes[axis], study.axes[axis]);
  write_file(path, text);
}

SensorModel read_sensor_model(const std::string& path) {
  const toml::table table = parse(path);
  SensorModel model;
  model.error.measured.emplace();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    (*model.error.measured)[axis] = read_axis(table, kAxes[axis], path);
    model.error.amplitude[static_cast<Eigen::Index>(axis)] =
        radians(number(table, std::string(kAxes[axis]) + ".amplitude_deg", path));
  }
  const std::vector<double> entries = numbers(table, "covariance_deg2", path);
  if (entries.size() != 9) throw Error("'covariance_deg2' has no nine numbers", path, kModelAdvice);
  model.covariance = Eigen::Matrix3d::Map(entries.data()) * (kRadiansPerDegree * kRadiansPerDegree);
  if (!model.covariance.isApprox(model.covariance.transpose(), 1e-9) ||
      Eigen::LLT<Eigen::Matrix3d>(model.covariance).info() != Eigen::Success)
    throw Error("'covariance_deg2' is not symmetric and positive definite", path, kModelAdvice);
  return model;
}

}  // namespace plumbline::app
