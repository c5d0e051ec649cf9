#include "reconstruction/recorded_sensor.h"

#include <fmt/format.h>

#include <array>
#include <utility>

#include "io/imu_file.h"
#include "io/recording.h"
#include "plumbline/error.h"
#include "plumbline/files.h"
#include "plumbline/time.h"
#include "sensor/orientation_filter.h"

namespace plumbline {
namespace {

std::string quaternion_text(const Eigen::Matrix3d& rotation) {
  const Eigen::Quaterniond q(rotation);
  return fmt::format("\"{:.4g} {:.4g} {:.4g} {:.4g}\"", q.x(), q.y(), q.z(), q.w());
}

/// Raw readings are made into orientations here, with all of them at hand.
std::vector<OrientationSample> filtered(const MountedImu& imu, bool has_mounting, OrientationStreamOptions* options,
                                        std::vector<std::string>* notes) {
  if (imu.body_from_camera && !has_mounting) {
    options->body_from_camera = *imu.body_from_camera;
    notes->push_back(fmt::format("raw readings whose format tells how the sensor sits: --mounting {}",
                                 quaternion_text(*imu.body_from_camera)));
  }
  if (!imu.recording.has_accelerometer) {
    notes->emplace_back("raw readings of a gyroscope alone: the turns are used, and where up is stays unknown");
    options->convention.has_up = false;
    return integrated_turns(imu.recording);
  }
  if (imu.recording.has_gyroscope) {
    notes->emplace_back("raw readings: filtered forward and backward, as `plumbline orientation --offline` does");
    return smooth_orientation(imu.recording);
  }
  options->convention.has_heading = false;
  return tilt_from_accelerometer(imu.recording, kTiltTau, true);
}

/// Names by which the sensor of a recording is called in messages: its file in a folder, else the recording.
std::string sensor_of(const SequenceInfo& info) {
  const std::string file = find_imu_file(info.path);
  return file.empty() ? info.path : file;
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

std::vector<OrientationSample> changed(const SensorOptions& options, std::vector<OrientationSample> samples) {
  return options.change ? options.change(std::move(samples)) : std::move(samples);
}

/// Raw readings as orientations, and as they are for the tracker.
void use_raw(const MountedImu& imu, const SensorOptions& options, SensorReadings* readings) {
  OrientationStreamOptions stream = options.stream;
  std::vector<OrientationSample> samples = filtered(imu, options.has_mounting, &stream, &readings->notes);
  if (imu.recording.has_gyroscope && (options.use_raw || !imu.recording.has_accelerometer))
    readings->inertial.emplace(imu.recording, stream.body_from_camera, stream.time_offset);
  readings->orientation.emplace(changed(options, std::move(samples)), stream);
  readings->sensor.has_heading = stream.convention.has_heading;
}

/// Of a chip that gives its orientation and, beside it, what it measured: the turn rates are for the tracker, too.
void use_raw_beside(const std::string& path, const OrientationStreamOptions& stream, SensorReadings* readings) {
  if (!has_gyroscope_columns(path)) return;
  try {
    readings->inertial.emplace(read_imu(path, &readings->notes), stream.body_from_camera, stream.time_offset);
    readings->notes.emplace_back("the turn rates beside the orientations are used as well");
  } catch (const Error& error) {
    readings->notes.push_back(fmt::format("the turn rates beside the orientations are not used: {}", error.what()));
  }
}

/// Why a recording's own readings cannot be used; empty if they can.
std::string reason_against(const MountedImu& imu, const SensorOptions& options, const std::string& name) {
  if (!imu.recording.has_gyroscope)
    return fmt::format("it gives the tilt alone, to a degree or two; --orientation {} uses it all the same", name);
  if (!imu.body_from_camera && !options.has_mounting)
    return fmt::format(
        "nothing says how it sits on the camera; --mounting \"QX QY QZ QW\" says it, and "
        "--orientation {} takes its axes for the camera's",
        name);
  return "";
}

/// Without samples where the recording has no sensor.
MountedImu recorded_imu(const Sequence& sequence, const std::string& name, std::vector<std::string>* notes) {
  MountedImu imu{sequence.read_imu(notes), sequence.info().body_from_camera};
  if (!imu.body_from_camera && name != sequence.info().path) imu.body_from_camera = mounting_by_format(name);
  return imu;
}

}  // namespace

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

void check_overlap(const OrientationStream& orientation, const Sequence& sequence, const std::string& path) {
  const std::string problem = overlap_problem(orientation, sequence);
  if (!problem.empty())
    throw Error(problem, path, "Give the readings of this recording, --orientation-offset, or --orientation none.");
}

SensorReadings read_sensor(const std::string& path, const SensorOptions& options) {
  SensorReadings readings;
  readings.source = path;
  if (holds_recording(path) || is_imu_file(path)) {
    use_raw(load_imu(path, &readings.notes), options, &readings);
  } else {
    OrientationStreamOptions stream = options.stream;
    std::vector<OrientationSample> samples =
        read_orientations(path, options.stream.convention, &readings.notes, &stream.convention);
    readings.orientation.emplace(changed(options, std::move(samples)), stream);
    readings.sensor.has_heading = stream.convention.has_heading;
    if (options.use_raw) use_raw_beside(path, stream, &readings);
  }
  if (!readings.sensor.has_heading) readings.notes.emplace_back("tilt only: the heading is left to the tracking");
  return readings;
}

SensorReadings recorded_sensor(const Sequence& sequence, const SensorOptions& options) {
  SensorReadings readings;
  const std::string name = sensor_of(sequence.info());
  const auto leave_out = [&](const std::string& why) {
    SensorReadings none;
    none.notes = readings.notes;
    none.unused = fmt::format("inertial sensor ({}): not used, because {}", name, why);
    return none;
  };
  try {
    const MountedImu imu = recorded_imu(sequence, name, &readings.notes);
    if (imu.recording.samples.empty()) return readings;
    if (const std::string why = reason_against(imu, options, name); !why.empty()) return leave_out(why);
    use_raw(imu, options, &readings);
  } catch (const Error& error) {
    return leave_out(error.what());
  }
  if (const std::string problem = overlap_problem(*readings.orientation, sequence); !problem.empty())
    return leave_out(problem);
  if (const std::string note = coverage_note(*readings.orientation, sequence); !note.empty())
    readings.notes.push_back(note);
  readings.source = fmt::format("the recording's own sensor ({})", name);
  return readings;
}

}  // namespace plumbline
