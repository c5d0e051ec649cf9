#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cli/arguments.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/orientation_arguments.h"
#include "eval/orientation_error.h"
#include "io/imu_file.h"
#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/files.h"
#include "plumbline/orientation.h"
#include "plumbline/time.h"
#include "reconstruction/recorded_sensor.h"
#include "sensor/madgwick.h"
#include "sensor/orientation_filter.h"

namespace plumbline::app {
namespace {

struct FilterArguments {
  std::string input, output = "orientation.txt", filter = "vqf", reference;
  double gain = kMadgwickGain;
  std::optional<double> tau;
  bool offline = false, no_magnetometer = false, no_gyroscope = false, json = false;
};

ImuRecording load(const FilterArguments& a) {
  std::vector<std::string> notes;
  ImuRecording recording = load_imu(a.input, &notes).recording;
  for (const std::string& note : notes) fmt::print(stderr, "note: {}\n", note);
  if (a.no_magnetometer) {
    recording.has_magnetometer = false;
    for (ImuSample& sample : recording.samples) sample.magnetic_field.reset();
  }
  if (a.no_gyroscope) recording.has_gyroscope = false;
  if (!a.reference.empty()) recording.reference = read_orientations(a.reference, {});
  return recording;
}

std::vector<OrientationSample> orientations_of(const ImuRecording& recording, const FilterArguments& a) {
  if (!recording.has_gyroscope) {
    if (a.filter == "madgwick") throw UsageError("needs a gyroscope", "--filter madgwick", "Leave the option out.");
    return tilt_from_accelerometer(recording, a.tau.value_or(a.offline ? kTiltTau : kTiltTauForward), a.offline);
  }
  if (a.filter == "madgwick") {
    if (a.offline) throw UsageError("has no backward pass", "--filter madgwick", "Leave out --offline.");
    return madgwick_orientation(recording, a.gain);
  }
  return a.offline ? smooth_orientation(recording) : filter_orientation(recording);
}

/// Of what the orientations are made, and what they mean.
std::string recording_text(const ImuRecording& recording) {
  const double seconds = to_seconds(recording.samples.back().time - recording.samples.front().time);
  std::string text = fmt::format("{} readings over {:.1f} s: accelerometer", recording.samples.size(), seconds);
  if (recording.has_gyroscope) text += ", gyroscope";
  if (recording.has_magnetometer && recording.has_gyroscope) text += ", magnetometer";
  return text;
}

std::string meaning(const ImuRecording& recording) {
  if (!recording.has_gyroscope) return "tilt only; the heading means nothing, and the file says so";
  if (!recording.has_magnetometer) return "tilt; the heading starts anywhere and drifts";
  return "tilt and heading, east north up";
}

nlohmann::ordered_json error_json(const eval::OrientationError& error) {
  return {{"pairs", error.count},
          {"total_deg", degrees(error.total)},
          {"heading_deg", degrees(error.heading)},
          {"inclination_deg", degrees(error.inclination)}};
}

int filter(const FilterArguments& a) {
  const ImuRecording recording = load(a);
  const std::vector<OrientationSample> samples = orientations_of(recording, a);
  write_orientations(a.output, samples, recording.has_gyroscope);
  if (a.json) {
    nlohmann::ordered_json json = {{"readings", samples.size()}, {"output", a.output}};
    if (!recording.reference.empty()) json["rmse"] = error_json(eval::orientation_error(recording.reference, samples));
    say(json.dump(2));
    return 0;
  }
  say("input    {}", recording_text(recording));
  say("output   {}: {}", a.output, meaning(recording));
  if (recording.reference.empty()) return 0;
  const eval::OrientationError error = eval::orientation_error(recording.reference, samples);
  say("rmse     total {:.3f}°  heading {:.3f}°  inclination {:.3f}°  against {} reference orientations",
      degrees(error.total), degrees(error.heading), degrees(error.inclination), error.count);
  return 0;
}

void add_options(CLI::App& command, FilterArguments& a) {
  command
      .add_option("imu", a.input,
                  "Readings: CSV with named columns, EuRoC, TUM accelerometer.txt, BROAD, or a recording with a sensor")
      ->required()
      ->type_name("IMU");
  command.add_option("-o,--output", a.output, "Orientations: t qx qy qz qw")->capture_default_str()->type_name("FILE");
  command.add_flag("--offline", a.offline, "Use the readings after each moment, too: forward and backward");
  command.add_option("--filter", a.filter, "vqf (Laidig and Seel 2023) or, to compare, madgwick")
      ->check(CLI::IsMember({"vqf", "madgwick"}))
      ->capture_default_str()
      ->type_name("NAME");
  command.add_option("--gain", a.gain, "Madgwick's beta, rad/s")->check(CLI::Range(0.0, 1e3))->capture_default_str();
  command
      .add_option(
          "--tilt-tau", a.tau,
          fmt::format("Without a gyroscope: time constant of the acceleration's low-pass, seconds (default: {}, "
                      "{} with --offline)",
                      kTiltTauForward, kTiltTau))
      ->check(CLI::Range(0.0, 1e3));
  command.add_flag("--no-magnetometer", a.no_magnetometer, "As if there were none");
  command.add_flag("--no-gyroscope", a.no_gyroscope, "As if there were none: tilt only");
  command.add_option("--reference", a.reference, "True orientations to compare with (default: those of a BROAD file)")
      ->type_name("FILE");
  command.add_flag("--json", a.json, "Print JSON");
}

}  // namespace

void add_orientation_command(CLI::App& app, Command& chosen) {
  const auto arguments = std::make_shared<FilterArguments>();
  CLI::App* command =
      app.add_subcommand("orientation", "Orientations from raw gyroscope, accelerometer and magnetometer");
  add_options(*command, *arguments);
  command->callback([arguments, &chosen] { chosen = [arguments] { return filter(*arguments); }; });
}

}  // namespace plumbline::app
