#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calibration/convention_check.h"
#include "calibration/mounting_calibration.h"
#include "cli/arguments.h"
#include "cli/backend_arguments.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/interrupt.h"
#include "cli/orientation_arguments.h"
#include "cli/parameter_arguments.h"
#include "cli/progress.h"
#include "cli/sequence_arguments.h"
#include "cli/sequence_text.h"
#include "io/trajectory.h"
#include "plumbline/angles.h"
#include "plumbline/calibration.h"
#include "plumbline/config.h"
#include "plumbline/error.h"
#include "plumbline/orientation_calibration.h"
#include "plumbline/se3.h"
#include "plumbline/trajectory.h"
#include "reconstruction/frame_source.h"

namespace plumbline::app {
namespace {

struct CalibrateArguments {
  SequenceArguments sequence;
  ParameterArguments parameters;
  OrientationArguments orientation;
  std::string output = "mounting.toml", depth_output, trajectory, trajectory_of = "camera", backend = "auto";
  int threads = 0, max_frames = 0;
  double search = OffsetSearch{}.longest;  // seconds
  bool force = false;
  std::string command_line;
};

void check(const CalibrateArguments& a) {
  if (a.sequence.path.empty() && a.trajectory.empty())
    throw UsageError("no sequence was given", "plumbline calibrate",
                     "Give the folder of a sequence, or the camera's poses with --trajectory.");
  if (!a.depth_output.empty() && (!a.trajectory.empty() || !a.sequence.depth_calibration.empty()))
    throw UsageError("the depth is calibrated where a sequence is tracked as it was measured", "--depth-output",
                     "Leave --trajectory and --depth-calibration out.");
  const OrientationArguments& o = a.orientation;
  if (o.path.empty() && a.depth_output.empty())
    throw UsageError("there is nothing to calibrate", "plumbline calibrate",
                     "Give the sensor's readings with --orientation, or --depth-output for the depth alone.");
  if (!o.mounting.empty() || o.offset || !o.calibration.empty())
    throw UsageError("mounting and time offset are what is looked for", "plumbline calibrate",
                     "Leave --mounting, --orientation-offset and --orientation-calibration out.");
}

/// From a file: world_from_camera, or the poses of a target as a camera sees it.
Trajectory read_poses(const CalibrateArguments& a) {
  std::vector<std::string> notes;
  Trajectory poses = read_trajectory(a.trajectory, &notes);
  for (const std::string& note : notes) say("note       {}", note);
  if (a.trajectory_of == "target")
    for (StampedPose& pose : poses) pose.world_from_camera = pose.world_from_camera.inverse();
  say("camera     {} poses from {}", poses.size(), a.trajectory);
  return poses;
}

void say_depth(const std::optional<DepthCalibrationResult>& depth) {
  if (depth)
    say("depth      {}; {} pairs of frames disagree by {:.4f}/m before, {:.4f}/m after", depth->distortion.describe(),
        depth->pairs, depth->before, depth->after);
  else
    say("note       the depth's distortion could not be told: too few frames overlap after the camera has moved");
}

void write_depth(const CalibrateArguments& a, const std::optional<DepthCalibrationResult>& depth) {
  if (!depth)
    throw Error("the depth's distortion could not be told", a.sequence.path,
                "Hold the camera where it sees a room full of things, and turn it about for ten seconds or more.");
  write_depth_calibration(a.depth_output, depth->distortion, depth_calibration_comments(*depth, a.command_line));
  say("written    {}; use it with `plumbline run SEQUENCE --depth-calibration {}`", a.depth_output, a.depth_output);
}

/// One bar for each pass over the frames.
class PassProgress {
 public:
  void update(const CalibrationProgress& state) {
    if (!bar_ || state.pass != pass_) bar_.emplace(state.total, false);
    pass_ = state.pass;
    bar_->update(state.done, state.tracked, state.done - state.tracked);
  }
  void clear() { bar_.reset(); }

 private:
  std::optional<Progress> bar_;
  int pass_ = 0;
};

Trajectory track(const CalibrateArguments& a) {
  const bool undistort = a.sequence.depth_calibration.empty();
  const InterruptGuard interrupt;
  PassProgress progress;
  CalibrationOptions options;
  options.parameters = effective_parameters(a.parameters);
  options.backend = a.backend;
  options.threads = a.threads;
  options.stopping = [&] { return interrupt.signal() != 0; };
  options.on_progress = [&](const CalibrationProgress& state) { progress.update(state); };
  validate(options.parameters);
  SequenceOptions input = sequence_options(a.sequence);
  input.color = false;
  const std::unique_ptr<Sequence> sequence = open_sequence(a.sequence.path, input);
  for (const std::string& line : describe(*sequence)) say(line);
  const CameraPath path = track_path(*sequence, chosen_frames(*sequence, a.max_frames),
                                     undistort ? TrackedDepth::undistorted : TrackedDepth::as_read, options);
  progress.clear();
  say("camera     {} of {} frames tracked", path.poses.size(), path.frames);
  if (path.poses.empty())
    throw Error("no frame has enough depth to begin with", a.sequence.path,
                "Check --depth-scale, preprocess.min_depth and preprocess.max_depth against the images.");
  if (undistort) say_depth(path.depth);
  if (!a.depth_output.empty()) write_depth(a, path.depth);
  return path.poses;
}

std::string quaternion_text(const Eigen::Matrix3d& rotation) {
  Eigen::Quaterniond q(rotation);
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  return fmt::format("{:.5f} {:.5f} {:.5f} {:.5f}", q.x(), q.y(), q.z(), q.w());
}

double degrees_between(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return degrees(so3::angle(a.transpose() * b));
}

Eigen::Vector3d mounting_sd(const MountingCalibration& c) { return c.covariance.diagonal().cwiseMax(0).cwiseSqrt(); }

void say_motion(const MountingCalibration& c) {
  const Eigen::Vector3d s = c.spread / kRadiansPerDegree;
  say("motion     {} frames over {:.1f} s, {:.0f}°/s rms; turned by {:.1f}°, {:.1f}° and {:.1f}° rms about its "
      "principal "
      "axes,",
      c.frames, c.duration, degrees(c.speed), s[0], s[1], s[2]);
  say("           the first of them {} in the camera's frame", axis_text(c.spread_axes.col(0)));
}

void say_result(const MountingCalibration& c) {
  const Eigen::Vector3d sd = mounting_sd(c) / kRadiansPerDegree, along = c.sd_along() / kRadiansPerDegree,
                        e = c.systematic / kRadiansPerDegree;
  say("speeds     correlation {:.3f} at a time offset of {:.1f} ms", c.correlation, 1e3 * c.first_offset);
  if (c.turns == 0) return;
  say("Tsai-Lenz  \"{}\"  residual {:.2f}° rms of {} turns", quaternion_text(c.tsai_lenz),
      degrees(c.tsai_lenz_residual), c.turns);
  say("Park-Martin \"{}\" residual {:.2f}°, {:.2f}° from Tsai-Lenz", quaternion_text(c.park_martin),
      degrees(c.park_martin_residual), degrees_between(c.park_martin, c.tsai_lenz));
  say("refined    \"{}\"  residual {:.2f}° rms of a frame, {:.2f}° from Park-Martin",
      quaternion_text(c.body_from_camera), degrees(c.residual), degrees_between(c.body_from_camera, c.park_martin));
  say("           with a drift of {:.2f}° between both, and a systematic error of the sensor of up to {:.1f}°, {:.1f}° "
      "(tilt)\n           and {:.1f}° (heading)",
      degrees(c.drift), e[0], e[1], e[2]);
  say("mounting   body_from_camera \"{}\", ± {:.2f}°, {:.2f}°, {:.2f}° about the camera's x, y, z",
      quaternion_text(c.body_from_camera), sd[0], sd[1], sd[2]);
  say("           (one standard deviation; {:.2f}° in the worst direction, {:.2f}° in the best; {:.1f} successive "
      "frames "
      "tell no\n           more than one)",
      along[2], along[0], c.redundancy);
  say("offset     {:.1f} ms, ± {:.1f} ms, to be added to the sensor's stamps", 1e3 * c.time_offset,
      1e3 * c.time_offset_sd);
}

/// Whether another convention fits better than the declared one, with the mounting that was found.
std::optional<std::string> convention_message(const Trajectory& camera, const OrientationStream& stream,
                                              const MountingCalibration& c) {
  std::vector<TurnPair> pairs;
  constexpr std::size_t kSpan = 10;
  for (std::size_t i = 0; i + kSpan < camera.size(); i += 3) {
    const StampedPose &a = camera[i], &b = camera[i + kSpan];
    const OrientationReading first = stream.lookup(a.time - from_seconds(c.time_offset)),
                             second = stream.lookup(b.time - from_seconds(c.time_offset));
    if (first.status != OrientationStatus::ok || second.status != OrientationStatus::ok) continue;
    pairs.push_back({a.world_from_camera.rotation().transpose() * b.world_from_camera.rotation(), first.earth_from_body,
                     second.earth_from_body});
  }
  const ConventionCheck check = check_convention(pairs, stream.options().convention, c.body_from_camera);
  if (check.verdict == ConventionVerdict::another_fits || check.verdict == ConventionVerdict::none_fits)
    return check.message;
  return std::nullopt;
}

void write(const CalibrateArguments& a, const OrientationStream& stream, const MountingCalibration& c) {
  write_orientation_calibration(
      a.output, {c.body_from_camera, mounting_sd(c), c.time_offset, c.time_offset_sd, stream.options().convention},
      {"How an orientation sensor is mounted, for `plumbline run --orientation-calibration FILE`. Made by",
       a.command_line,
       fmt::format("from {} frames; motion: {}; residual {:.2f} degrees rms.", c.frames, to_string(c.verdict),
                   degrees(c.residual))});
  say("written    {}; use it with `plumbline run SEQUENCE --orientation FILE --orientation-calibration {}`", a.output,
      a.output);
}

int calibrate(const CalibrateArguments& a) {
  check(a);
  if (a.orientation.path.empty()) {
    track(a);
    return 0;
  }
  const SensorReadings readings = load_orientation(a.orientation);
  const OrientationStream& stream = *readings.orientation;
  if (!stream.options().convention.has_heading)
    throw UsageError("has the tilt only, where a calibration needs the whole orientation", "--orientation",
                     "Give a file with headings.");
  const Trajectory camera = a.trajectory.empty() ? track(a) : read_poses(a);
  say("orientation {} readings from {}", stream.samples().size(), describe(a.orientation));
  for (const std::string& note : readings.notes) say("note       {}", note);
  MountingOptions options;
  options.search.longest = a.search;
  const MountingCalibration c = calibrate_mounting(camera, stream, options);
  say_motion(c);
  say_result(c);
  const std::optional<std::string> message = convention_message(camera, stream, c);
  if (message) say("note       {}", *message);
  if (c.verdict != MotionVerdict::good && !a.force)
    throw Error(c.advice + "\n  Nothing was written; --force writes it all the same", to_string(c.verdict).data(), "");
  if (c.verdict != MotionVerdict::good) say("note       {}: {}", to_string(c.verdict), c.advice);
  if (c.verdict == MotionVerdict::good) say("verdict    the motion was rich enough");
  write(a, stream, c);
  return 0;
}

void add_options(CLI::App& command, CalibrateArguments& a) {
  add_sequence_arguments(command, a.sequence, false);
  add_parameter_arguments(command, a.parameters);
  add_orientation_arguments(command, a.orientation);
  command.add_option("-o,--output", a.output, "File for the result")->capture_default_str()->type_name("FILE");
  command
      .add_option("--depth-output", a.depth_output,
                  "Also a file for the depth camera's own distortion, for --depth-calibration; needs no --orientation")
      ->type_name("FILE");
  CLI::Option* trajectory =
      command
          .add_option("--trajectory", a.trajectory, "Poses of the camera, in place of tracking it through a sequence")
          ->type_name("FILE");
  command.add_option("--trajectory-of", a.trajectory_of, "camera: world_from_camera; target: camera_from_target")
      ->needs(trajectory)
      ->check(CLI::IsMember({"camera", "target"}))
      ->capture_default_str();
  command.add_option("--search", a.search, "Largest time offset either way")
      ->check(CLI::Range(0.01, 1000.0))
      ->capture_default_str()
      ->type_name("SECONDS");
  command.add_option("--max-frames", a.max_frames, "Stop after so many frames, 0 for all")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str()
      ->type_name("N");
  add_backend_arguments(command, a.backend, a.threads);
  command.add_flag("--force", a.force, "Write the file even if the motion was too poor");
}

}  // namespace

void add_calibrate_command(CLI::App& app, Command& chosen, const std::string& command_line) {
  const auto arguments = std::make_shared<CalibrateArguments>();
  CLI::App* command =
      app.add_subcommand("calibrate", "How an orientation sensor is mounted on the camera, and how its clock differs");
  add_options(*command, *arguments);
  command->footer(
      "Hold the camera where it sees a room full of things, and turn it for ten seconds or more by 40° each way about "
      "all\n"
      "three axes. The camera is tracked by its depth alone; no target is needed. The distortion of its depth is "
      "found\n"
      "from frames that saw the same things, and taken out. If the motion was too poor, nothing "
      "is\n"
      "written, the exit code is 1, and the message says what to do.");
  arguments->command_line = command_line;
  command->callback([arguments, &chosen] { chosen = [arguments] { return calibrate(*arguments); }; });
}

}  // namespace plumbline::app
