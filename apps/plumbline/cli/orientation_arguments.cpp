#include "cli/orientation_arguments.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>

#include "calibration/orientation_calibration.h"
#include "cli/arguments.h"
#include "cli/sensor_model.h"
#include "io/imu_file.h"
#include "io/orientation_file.h"
#include "io/recording.h"
#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/orientation.h"
#include "plumbline/time.h"
#include "sensor/error_model.h"
#include "sensor/orientation_filter.h"
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

void note_error_model(const OrientationErrorModel& model, std::vector<std::string>* notes) {
  if (notes == nullptr || model.amplitude.isZero(0)) return;
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

std::string quoted_quaternion(const Eigen::Matrix3d& rotation) {
  const Eigen::Quaterniond q(rotation);
  return fmt::format("\"{:.4g} {:.4g} {:.4g} {:.4g}\"", q.x(), q.y(), q.z(), q.w());
}

/// Raw readings are made into orientations here, with all of them at hand.
std::vector<OrientationSample> filtered(const MountedImu& imu, const OrientationArguments& a,
                                        OrientationStreamOptions* options, std::vector<std::string>* notes) {
  const auto note = [&](const std::string& text) {
    if (notes != nullptr) notes->push_back(text);
  };
  if (imu.body_from_camera && !names_mounting(a)) {
    options->body_from_camera = *imu.body_from_camera;
    note(fmt::format("raw readings whose format tells how the sensor sits: --mounting {}",
                     quoted_quaternion(*imu.body_from_camera)));
  }
  if (imu.recording.has_gyroscope) {
    note("raw readings: filtered forward and backward, as `plumbline orientation --offline` does");
    return smooth_orientation(imu.recording);
  }
  options->convention.has_heading = false;
  return tilt_from_accelerometer(imu.recording, kTiltTau, true);
}

/// Names by which the sensor of a recording is called in messages: its file in a folder, else the recording.
std::string sensor_of(const SequenceInfo& info) {
  for (const char* name : {"imu.csv", "accelerometer.txt"})
    if (std::error_code error; std::filesystem::exists(std::filesystem::path(info.path) / name, error))
      return (std::filesystem::path(info.path) / name).string();
  return info.path;
}

std::string seconds_text(double first, double final) { return fmt::format("{:.3f} to {:.3f} s", first, final); }

/// The unit that the sensor's stamps seem to be in: with it they would lie at the frames, or, counted from another
/// moment, span about as long as these.
std::string unit_hint(double first, double final, double frames_first, double frames_final) {
  struct Unit {
    double factor;
    const char* text;
  };
  constexpr std::array kUnits = {
      Unit{1e-3, "milliseconds where seconds are expected"}, Unit{1e-6, "microseconds where seconds are expected"},
      Unit{1e-9, "nanoseconds where seconds are expected"},  Unit{1e3, "seconds, and the frames' in milliseconds"},
      Unit{1e6, "seconds, and the frames' in microseconds"}, Unit{1e9, "seconds, and the frames' in nanoseconds"}};
  constexpr double kAlike = 10;  // a sensor that was started or ended at another time
  const double ratio = (final - first) / (frames_final - frames_first);
  const auto spans_alike = [&](const Unit& unit) {
    return ratio * unit.factor < kAlike && ratio * unit.factor > 1 / kAlike;
  };
  for (const Unit& unit : kUnits)
    if (spans_alike(unit) && first * unit.factor <= frames_final && final * unit.factor >= frames_first)
      return fmt::format("the sensor's stamps seem to be in {}", unit.text);
  for (const Unit& unit : kUnits)
    if (spans_alike(unit) && (ratio > 100 || ratio < 0.01))
      return fmt::format("by their span the sensor's stamps seem to be in {}, and to count from another moment",
                         unit.text);
  return "";
}

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

std::optional<OrientationStream> load_orientation(const OrientationArguments& a, std::vector<std::string>* notes,
                                                  std::optional<ImuStream>* inertial) {
  if (!is_file(a)) return std::nullopt;
  OrientationStreamOptions options = stream_options(a);
  const OrientationConvention declared = options.convention;
  const OrientationErrorModel model = a.imu_model.empty() ? OrientationErrorModel{} : error_model_of(a);
  if (std::error_code error; !std::filesystem::exists(a.path, error))
    throw UsageError("there is no such file", "--orientation " + a.path,
                     "Give a file with lines t qx qy qz qw, or in TUM's or EuRoC's format.");
  const bool raw = holds_recording(a.path) || is_imu_file(a.path);
  std::vector<OrientationSample> samples;
  if (raw) {
    const MountedImu imu = load_imu(a.path, notes);
    samples = filtered(imu, a, &options, notes);
    if (inertial != nullptr && !models_orientation(a) && imu.recording.has_gyroscope)
      inertial->emplace(imu.recording, options.body_from_camera, options.time_offset);
  } else {
    samples = read_orientations(a.path, declared, notes, &options.convention);
  }
  if (!options.convention.has_heading && notes != nullptr)
    notes->emplace_back("tilt only: the heading is left to the tracking");
  note_error_model(model, notes);
  return OrientationStream(with_error(model, std::move(samples)), options);
}

MountedImu load_imu(const std::string& path, std::vector<std::string>* notes) {
  if (!holds_recording(path)) return {read_imu(path, notes), mounting_by_format(path)};
  const auto sequence = open_sequence(path);
  MountedImu imu{sequence->read_imu(notes), sequence->info().body_from_camera};
  if (imu.recording.samples.empty())
    throw Error("has no readings of an inertial sensor that serve", path, "give a recording with an accelerometer");
  return imu;
}

std::string overlap_problem(const OrientationStream& stream, const Sequence& sequence) {
  for (int i = 0; i < sequence.size(); ++i)
    if (stream.lookup(sequence.time(i)).status == OrientationStatus::ok) return "";
  const double first = to_seconds(stream.samples().front().time), final = to_seconds(stream.samples().back().time);
  const double frames_first = to_seconds(sequence.info().first_time),
               frames_final = to_seconds(sequence.info().last_time);
  std::string text = fmt::format("no reading lies at any frame: the sensor's stamps are {}, the frames' {}",
                                 seconds_text(first, final), seconds_text(frames_first, frames_final));
  if (first <= frames_final && final >= frames_first) return text + "; the readings have gaps there";
  const std::string unit = unit_hint(first, final, frames_first, frames_final);
  if (!unit.empty()) return text + "; " + unit;
  return text + fmt::format("; if both began at the same moment, --orientation-offset {:.3f} brings them together",
                            frames_first - first);
}

std::string coverage_note(const OrientationStream& stream, const Sequence& sequence) {
  int served = 0;
  for (int i = 0; i < sequence.size(); ++i)
    served += stream.lookup(sequence.time(i)).status == OrientationStatus::ok ? 1 : 0;
  if (10 * served >= 9 * sequence.size()) return "";
  return fmt::format(
      "the sensor's readings lie at {} of the {} frames alone: the sensor's stamps are {}, the frames' {}", served,
      sequence.size(),
      seconds_text(to_seconds(stream.samples().front().time), to_seconds(stream.samples().back().time)),
      seconds_text(to_seconds(sequence.info().first_time), to_seconds(sequence.info().last_time)));
}

RecordedOrientation recorded_orientation(const Sequence& sequence, const OrientationArguments& a) {
  const SequenceInfo& info = sequence.info();
  RecordedOrientation result;
  const std::string name = sensor_of(info);
  const auto leave_out = [&](const std::string& why) {
    result.unused = fmt::format("inertial sensor ({}): not used, because {}", name, why);
    return result;
  };
  MountedImu imu;
  try {
    imu.recording = sequence.read_imu(&result.notes);
    imu.body_from_camera = info.body_from_camera;
    if (!imu.body_from_camera && name != info.path) imu.body_from_camera = mounting_by_format(name);
  } catch (const Error& error) {
    return leave_out(error.what());
  }
  if (imu.recording.samples.empty()) return result;
  if (!imu.recording.has_gyroscope)
    return leave_out(
        fmt::format("it gives the tilt alone, to a degree or two; --orientation {} uses it all the same", name));
  if (!imu.body_from_camera && !names_mounting(a))
    return leave_out(
        fmt::format("nothing says how it sits on the camera; --mounting \"QX QY QZ QW\" says it, and "
                    "--orientation {} takes its axes for the camera's",
                    name));
  OrientationStreamOptions options = stream_options(a);
  const OrientationErrorModel model = a.imu_model.empty() ? OrientationErrorModel{} : error_model_of(a);
  std::vector<OrientationSample> samples = filtered(imu, a, &options, &result.notes);
  note_error_model(model, &result.notes);
  OrientationStream stream(with_error(model, std::move(samples)), options);
  if (const std::string problem = overlap_problem(stream, sequence); !problem.empty()) return leave_out(problem);
  if (!models_orientation(a)) result.inertial.emplace(imu.recording, options.body_from_camera, options.time_offset);
  if (const std::string note = coverage_note(stream, sequence); !note.empty()) result.notes.push_back(note);
  result.stream.emplace(std::move(stream));
  result.source = fmt::format("the recording's own sensor ({})", name);
  return result;
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
