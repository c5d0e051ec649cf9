#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "cli/arguments.h"
#include "cli/backend_arguments.h"
#include "cli/browser.h"
#include "cli/capture_arguments.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/orientation_arguments.h"
#include "cli/parameter_arguments.h"
#include "cli/sequence_arguments.h"
#include "commands/fusion_arguments.h"
#include "plumbline/config.h"
#include "plumbline/error.h"
#include "plumbline/sequence.h"
#include "plumbline/trajectory.h"
#include "reconstruction/recorded_sensor.h"
#include "report/report.h"
#include "run/live_source.h"
#include "run/reconstruction.h"
#include "view/view_arguments.h"

namespace plumbline::app {
namespace {

constexpr std::string_view kLive = "live:";

struct RunArguments {
  SequenceArguments sequence;
  ParameterArguments parameters;
  OrientationArguments orientation;
  CaptureArguments capture;
  std::string output = "out", backend = "auto", initial_pose, groundtruth;
  int threads = 0, max_frames = 0, stride = 1;
  std::vector<std::string> left_out;
  std::vector<int> pixel_use_frames, icp_frames;
  FusionArguments fusion;
  ViewArguments view;
  bool realtime = false, no_mesh = false, no_report = false, no_view = false, quiet = false, print_config = false;
  std::string command_line;
};

TimeSpan parse_span(std::string text) {
  std::replace(text.begin(), text.end(), ':', ',');
  const std::vector<double> ends = parse_numbers(text, 2, "--leave-out", "FROM:TO, seconds");
  if (!(ends[0] < ends[1])) throw UsageError("the part ends before it begins", "--leave-out", "Give FROM:TO, seconds.");
  return {ends[0], ends[1]};
}

ReconstructionOptions reconstruction_options(const RunArguments& arguments) {
  ReconstructionOptions options;
  options.sequence = arguments.sequence.path;
  options.output = arguments.output;
  options.input = sequence_options(arguments.sequence);
  options.parameters = effective_parameters(arguments.parameters);
  options.sensor.covariance = sensor_covariance(arguments.orientation);
  options.backend = arguments.backend;
  options.threads = arguments.threads;
  options.max_frames = arguments.max_frames;
  options.stride = arguments.stride;
  for (const std::string& span : arguments.left_out) options.left_out.push_back(parse_span(span));
  options.realtime = arguments.realtime ? arguments.capture.speed : 0;
  if (!arguments.initial_pose.empty()) options.initial_pose = parse_pose(arguments.initial_pose, "--initial-pose");
  options.groundtruth = arguments.groundtruth;
  options.mesh = !arguments.no_mesh;
  set_up_fusion(arguments.fusion, arguments.parameters.preset, &options);
  options.report = !arguments.no_report;
  options.write_report = report_writer();
  options.pixel_use_frames = arguments.pixel_use_frames;
  options.icp_frames = arguments.icp_frames;
  options.quiet = arguments.quiet;
  options.command_line = arguments.command_line;
  return options;
}

void set_up_live(const RunArguments& arguments, ReconstructionOptions* options) {
  if (arguments.orientation.path != kAutoOrientation && arguments.orientation.path != kNoOrientation)
    throw UsageError("a file of orientations does not go with a live camera", "--orientation", "Give --imu.");
  if (arguments.stride != 1) throw UsageError("a live run takes what comes", "--stride", "Leave it out.");
  if (arguments.realtime) throw UsageError("a live run is in real time", "--realtime", "Leave it out.");
  if (!arguments.orientation.imu_model.empty() || !arguments.orientation.quaternion.empty())
    throw UsageError("these are of files of orientations, not of a sensor", "--imu-model, --quaternion",
                     "Leave them out.");
  const OrientationStreamOptions orientation = stream_options(arguments.orientation);
  if (arguments.capture.imu != "none") options->orientation_source = arguments.capture.imu;
  options->open_live = [arguments, orientation, input = options->input] {
    return std::make_unique<LiveSource>(arguments.capture, input.color, input.intrinsics, arguments.max_frames,
                                        orientation, input.depth_distortion);
  };
}

void use(SensorReadings readings, ReconstructionOptions* options) {
  options->sensor.has_heading = readings.sensor.has_heading;
  options->orientation = std::move(readings.orientation);
  options->inertial = std::move(readings.inertial);
  options->orientation_source = readings.source;
  options->orientation_notes = std::move(readings.notes);
  options->unused = readings.unused;
}

/// Of the recording's own sensor, or of a file, which must then serve some frame.
void set_up_orientation(const OrientationArguments& arguments, ReconstructionOptions* options) {
  SensorReadings readings = load_orientation(arguments);
  const bool automatic = arguments.path == kAutoOrientation;
  if (automatic || readings.orientation) options->opened = open_sequence(options->sequence, options->input);
  if (automatic) {
    readings = recorded_orientation(*options->opened, arguments);
  } else if (readings.orientation) {
    check_overlap(*readings.orientation, *options->opened, "--orientation " + arguments.path);
    const std::string note = coverage_note(*readings.orientation, *options->opened);
    if (!note.empty()) readings.notes.push_back(note);
  }
  use(std::move(readings), options);
}

/// On a desktop a live run has its page without being told to.
ViewArguments view_arguments(const RunArguments& arguments, bool live) {
  ViewArguments view = arguments.view;
  if (live && view.port.empty() && !arguments.no_view && has_desktop()) view.port = kFreePort;
  return view;
}

int run(const RunArguments& arguments) {
  ReconstructionOptions options = reconstruction_options(arguments);
  if (arguments.print_config) {
    validate(options.parameters);
    say(to_toml(options.parameters));
    return 0;
  }
  if (options.sequence.empty())
    throw UsageError("no sequence was given", "plumbline run", "Give the folder of a sequence, or live:.");
  const bool live = options.sequence == kLive;
  if (live && !options.left_out.empty())
    throw UsageError("a live run takes what comes", "--leave-out", "Leave out the option.");
  if (live) {
    set_up_live(arguments, &options);
  } else {
    if (arguments.realtime && arguments.capture.speed <= 0)
      throw UsageError("real time needs a speed above 0", "--speed", "Give 1, or leave out --realtime.");
    if (arguments.capture.imu != "none")
      throw UsageError("a sensor is read in live runs alone", "--imu", "Run live:, or give --orientation FILE.");
    set_up_orientation(arguments.orientation, &options);
  }
  options.view = open_view(view_arguments(arguments, live));
  const Reconstruction result = reconstruct(options);
  // Ctrl-C is how a live run ends.
  return result.signal == 0 || live ? 0 : 128 + result.signal;
}

void add_options(CLI::App& command, RunArguments& arguments) {
  add_sequence_arguments(command, arguments.sequence, false);
  add_parameter_arguments(command, arguments.parameters);
  add_orientation_arguments(command, arguments.orientation, true);
  add_capture_arguments(command, arguments.capture);
  command.add_option("-o,--output", arguments.output, "Folder for the results, created if missing")
      ->capture_default_str()
      ->type_name("DIR");
  add_backend_arguments(command, arguments.backend, arguments.threads);
  command.add_option("--max-frames", arguments.max_frames, "Stop after so many frames, 0 for all")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str()
      ->type_name("N");
  command.add_option("--stride", arguments.stride, "Take every Nth frame")
      ->check(CLI::Range(1, 1 << 30))
      ->capture_default_str()
      ->type_name("N");
  command
      .add_option("--leave-out", arguments.left_out,
                  "Leave out this part of the recording, as if the camera had been covered; seconds after its start")
      ->allow_extra_args(false)
      ->type_name("FROM:TO");
  command.add_flag("--realtime", arguments.realtime,
                   "Play the sequence as its camera gave it, at --speed, and drop the frames that come too fast");
  command
      .add_option("--initial-pose", arguments.initial_pose, "Pose of the first camera in the world (default: identity)")
      ->type_name("\"TX TY TZ QX QY QZ QW\"");
  command
      .add_option("--groundtruth", arguments.groundtruth,
                  "Trajectory to evaluate against (default: the sequence's own)")
      ->type_name("FILE");
  command
      .add_option("--dump-pixel-use", arguments.pixel_use_frames,
                  "Paint why each pixel of this frame was or was not used")
      ->check(CLI::NonNegativeNumber)
      ->allow_extra_args(false)
      ->type_name("FRAME");
  command
      .add_option("--dump-icp", arguments.icp_frames,
                  "Write this frame's iterations: distance distribution, median, matched part, step, residual")
      ->check(CLI::NonNegativeNumber)
      ->allow_extra_args(false)
      ->type_name("FRAME");
  add_view_arguments(command, arguments.view);
  command.add_flag("--no-view", arguments.no_view, "No page, for a live run on a desktop");
  add_fusion_arguments(command, arguments.fusion);
  command.add_flag("--no-mesh", arguments.no_mesh, "Do not extract and write the mesh");
  command.add_flag("--no-report", arguments.no_report, "Do not write report.html");
  command.add_flag("--quiet", arguments.quiet, "Print nothing but errors");
  command.add_flag("--print-config", arguments.print_config, "Print every parameter with its value and help, and stop");
}

}  // namespace

void add_run_command(CLI::App& app, Command& chosen, const std::string& command_line) {
  const auto arguments = std::make_shared<RunArguments>();
  CLI::App* command = app.add_subcommand("run", "Reconstruct a sequence: trajectory, mesh and figures into a folder");
  add_options(*command, *arguments);
  command->footer(
      "`plumbline run live:` reconstructs what a camera sees, from the devices of --depth and --imu.\n"
      "Writes trajectory.txt (and trajectory_live.txt, if it was corrected), mesh.ply, frames.csv, config.toml, "
      "summary.json and report.html into DIR.\n"
      "Ctrl-C finishes the current frame and writes everything; the exit code is then 130.");
  arguments->command_line = command_line;
  command->callback([arguments, &chosen] { chosen = [arguments] { return run(*arguments); }; });
}

}  // namespace plumbline::app
