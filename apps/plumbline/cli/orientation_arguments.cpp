#include "cli/orientation_arguments.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>

#include "cli/arguments.h"
#include "cli/sensor_model.h"
#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/orientation.h"
#include "plumbline/orientation_calibration.h"
#include "sensor/error_model.h"
#include "tracking/orientation_guide.h"

namespace plumbline::app {
namespace {

/// The value of an option by its name; `otherwise` where it was not given.
template <class E, class Default>
Default choice(const std::string& text, const char* option, Default otherwise) {
  if (text.empty()) return otherwise;
  constexpr auto kNames = names(E{});
  const auto found = std::find(kNames.begin(), kNames.end(), text);
  if (found == kNames.end())
    throw UsageError("there is no '" + text + "'", option, fmt::format("Take one of: {}.", fmt::join(kNames, ", ")));
  return static_cast<E>(found - kNames.begin());
}

/// What the options say, on top of what is known already.
OrientationConvention convention_of(const OrientationArguments& a, OrientationConvention convention) {
  convention.quaternion = choice<QuaternionOrder>(a.quaternion, "--quaternion", convention.quaternion);
  convention.orientation_of = choice<OrientationOf>(a.orientation_of, "--orientation-of", convention.orientation_of);
  convention.earth = choice<EarthAxes>(a.earth, "--earth", convention.earth);
  return convention;
}

Eigen::Matrix3d mounting_of(const std::string& text, const Eigen::Matrix3d& otherwise) {
  if (text.empty()) return otherwise;
  parse_numbers(text, 4, "--mounting", "\"QX QY QZ QW\"");
  return parse_pose("0 0 0 " + text, "--mounting").rotation();
}

OrientationErrorModel error_model_of(const OrientationArguments& a) {
  constexpr const char* kOption = "--imu-model";
  OrientationErrorModel model;
  if (a.imu_model.ends_with(".toml")) return read_sensor_model(a.imu_model).error;
  if (a.imu_model.find_first_of("0123456789") == 0 || a.imu_model.find(',') != std::string::npos) {
    const std::vector<double> n = parse_numbers(a.imu_model, 3, kOption, "AX,AY,AZ in degrees");
    for (const double degrees : n)
      if (degrees < 0 || degrees > 180)
        throw UsageError(fmt::format("{} is out of range", degrees), kOption, "Give degrees from 0 to 180.");
    model.amplitude = kRadiansPerDegree * Eigen::Vector3d(n[0], n[1], n[2]);
  } else {
    try {
      model = error_model(a.imu_model);
    } catch (const Error&) {
      throw UsageError("there is no error model '" + a.imu_model + "'", kOption,
                       "Take ideal, bno055, three amplitudes in degrees, such as 3,3,10, or a file of `plumbline "
                       "characterise` that ends in .toml.");
    }
  }
  model.seed = a.imu_seed;
  return model;
}

void note_error_model(const OrientationArguments& arguments, std::vector<std::string>* notes) {
  const OrientationErrorModel model = arguments.imu_model.empty() ? OrientationErrorModel{} : error_model_of(arguments);
  if (model.amplitude.isZero(0)) return;
  const Eigen::Vector3d a = model.amplitude / kRadiansPerDegree;
  if (model.measured) {
    notes->push_back(
        fmt::format("a measured systematic error of up to {:.3g}°, {:.3g}° (tilt) and {:.3g}° (heading) was added",
                    a.x(), a.y(), a.z()));
    return;
  }
  notes->push_back(
      fmt::format("a systematic error of up to {:.6g}°, {:.6g}° (tilt) and {:.6g}° (heading) was added, seed {}", a.x(),
                  a.y(), a.z(), model.seed));
}

bool is_file(const OrientationArguments& a) {
  return !a.path.empty() && a.path != kAutoOrientation && a.path != kNoOrientation;
}

/// An error or an uncertainty that is given is one of orientations, which are then to be used and not the raw readings.
bool models_orientation(const OrientationArguments& a) { return !a.imu_model.empty() || !a.sensor_model.empty(); }

bool names_mounting(const OrientationArguments& a) { return !a.mounting.empty() || !a.calibration.empty(); }

}  // namespace

void add_orientation_arguments(CLI::App& command, OrientationArguments& a, bool automatic) {
  CLI::Option* file = command.add_option("--orientation", a.path,
                                         "Readings of an orientation sensor: t qx qy qz qw, TUM's or EuRoC's "
                                         "format, or raw readings that `plumbline orientation` reads");
  file->type_name("FILE");
  if (automatic) {
    a.path = kAutoOrientation;
    file->description(file->get_description() + "; auto takes the recording's own sensor, if it has one that serves");
    file->type_name("auto|none|FILE")->capture_default_str();
  }
  std::vector<CLI::Option*> dependents;
  const auto add = [&](const char* name, auto& value, const char* help, const char* type) {
    CLI::Option* option = command.add_option(name, value, help)->type_name(type);
    dependents.push_back(option);
    return option;
  };
  add("--orientation-calibration", a.calibration,
      "Mounting, time offset and convention from `plumbline calibrate`; the options below go before it", "FILE");
  add("--quaternion", a.quaternion, "Order in the file (default: by its format)", "xyzw|wxyz");
  add("--orientation-of", a.orientation_of, "What it turns into what (default: body-to-world)",
      "body-to-world|world-to-body");
  add("--earth", a.earth, "Earth axes of the file (default: enu)", "enu|ned|y-up");
  add("--orientation-offset", a.offset, "Seconds added to the sensor's stamps (default: 0)", "SECONDS")
      ->check(CLI::Range(-1e9, 1e9));
  add("--mounting", a.mounting, "body_from_camera (default: \"0 0 0 1\")", "\"QX QY QZ QW\"");
  add("--orientation-max-gap", a.max_gap, "Longest time between two readings that is bridged", "SECONDS")
      ->check(CLI::Range(1e-6, 1e3))
      ->capture_default_str();
  CLI::Option* model = add("--imu-model", a.imu_model, "Adds a systematic error, to degrade an ideal orientation",
                           "ideal|bno055|AX,AY,AZ|FILE.toml");
  add("--sensor-model", a.sensor_model, "Takes the sensor's uncertainty from a file of `plumbline characterise`",
      "FILE.toml");
  add("--imu-seed", a.imu_seed, "Of that error", "N")->needs(model)->capture_default_str();
  command.parse_complete_callback([&command, file, dependents, automatic] {
    if (automatic && file->count() == 0) return;
    const CLI::Option* sensor = command.get_option_no_throw("--imu");
    if (file->count() > 0 || (sensor != nullptr && sensor->count() > 0)) return;
    for (const CLI::Option* option : dependents)
      if (option->count() > 0) throw CLI::RequiresError(option->get_name(), file->get_name());
  });
}

OrientationStreamOptions stream_options(const OrientationArguments& a) {
  OrientationStreamOptions options;
  const OrientationCalibration calibration =
      a.calibration.empty() ? OrientationCalibration{} : read_orientation_calibration(a.calibration);
  options.time_offset = a.offset.value_or(calibration.time_offset);
  options.max_gap = a.max_gap;
  options.body_from_camera = mounting_of(a.mounting, calibration.body_from_camera);
  options.convention = convention_of(a, calibration.convention);
  return options;
}

/// What the options say of the sensor.
SensorOptions sensor_options(const OrientationArguments& a) {
  SensorOptions options{
      .stream = stream_options(a), .has_mounting = names_mounting(a), .use_raw = !models_orientation(a)};
  if (a.imu_model.empty()) return options;
  options.change = [model = error_model_of(a)](std::vector<OrientationSample> samples) {
    return with_error(model, std::move(samples));
  };
  return options;
}

SensorReadings load_orientation(const OrientationArguments& a) {
  if (!is_file(a)) return {};
  const SensorOptions options = sensor_options(a);
  if (std::error_code error; !std::filesystem::exists(a.path, error))
    throw UsageError("there is no such file", "--orientation " + a.path,
                     "Give a file with lines t qx qy qz qw, or in TUM's or EuRoC's format.");
  SensorReadings readings = read_sensor(a.path, options);
  readings.source = describe(a);
  note_error_model(a, &readings.notes);
  return readings;
}

SensorReadings recorded_orientation(const Sequence& sequence, const OrientationArguments& a) {
  SensorReadings readings = recorded_sensor(sequence, sensor_options(a));
  if (readings.orientation) note_error_model(a, &readings.notes);
  return readings;
}

std::optional<Eigen::Matrix3d> sensor_covariance(const OrientationArguments& a) {
  if (a.sensor_model.empty()) return std::nullopt;
  return read_sensor_model(a.sensor_model).covariance;
}

std::string describe(const OrientationArguments& a) {
  if (!is_file(a)) return "";
  if (a.imu_model.empty()) return a.path;
  return fmt::format("{}, error model {} seed {}", a.path, a.imu_model, a.imu_seed);
}

std::vector<std::string> describe(const OrientationStream& stream, const std::string& source,
                                  const std::vector<std::string>& notes, const OrientationParameters& parameters) {
  std::vector<std::string> lines = {fmt::format("orientation {} readings from {}", stream.samples().size(), source)};
  for (const std::string& note : notes) lines.push_back("note       " + note);
  if (!uses_sensor(parameters))
    lines.emplace_back("note       the parameters leave the orientation unused; --preset plumbline or paper uses it");
  return lines;
}

}  // namespace plumbline::app
