#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "app/arguments.h"
#include "app/commands.h"
#include "app/console.h"
#include "app/orientation_arguments.h"
#include "app/parameter_arguments.h"
#include "app/reconstruction.h"
#include "app/sequence_arguments.h"
#include "core/config.h"

namespace plumbline::app {
namespace {

struct RunArguments {
  SequenceArguments sequence;
  ParameterArguments parameters;
  OrientationArguments orientation;
  std::string output = "out", backend = "auto", initial_pose, groundtruth;
  int threads = 0, max_frames = 0, stride = 1;
  std::vector<int> pixel_use_frames, icp_frames;
  bool no_mesh = false, quiet = false, print_config = false;
  std::string command_line;
};

ReconstructionOptions reconstruction_options(const RunArguments& arguments) {
  ReconstructionOptions options;
  options.sequence = arguments.sequence.path;
  options.output = arguments.output;
  options.input = sequence_options(arguments.sequence);
  options.parameters = effective_parameters(arguments.parameters);
  apply_sensor_model(arguments.orientation, &options.parameters.orientation);
  options.backend = arguments.backend;
  options.threads = arguments.threads;
  options.max_frames = arguments.max_frames;
  options.stride = arguments.stride;
  if (!arguments.initial_pose.empty()) options.initial_pose = parse_pose(arguments.initial_pose, "--initial-pose");
  options.groundtruth = arguments.groundtruth;
  options.mesh = !arguments.no_mesh;
  options.pixel_use_frames = arguments.pixel_use_frames;
  options.icp_frames = arguments.icp_frames;
  options.quiet = arguments.quiet;
  options.command_line = arguments.command_line;
  return options;
}

int run(const RunArguments& arguments) {
  ReconstructionOptions options = reconstruction_options(arguments);
  if (arguments.print_config) {
    validate(options.parameters);
    say(to_toml(options.parameters));
    return 0;
  }
  if (options.sequence.empty())
    throw UsageError("no sequence was given", "plumbline run", "Give the folder of a sequence.");
  options.orientation = load_orientation(arguments.orientation, &options.orientation_notes);
  if (options.orientation && !options.orientation->options().convention.has_heading)
    options.parameters.orientation.heading_sigma = kNoHeadingSigma;
  options.orientation_source = describe(arguments.orientation);
  const Reconstruction result = reconstruct(options);
  return result.signal == 0 ? 0 : 128 + result.signal;
}

void add_options(CLI::App& command, RunArguments& arguments) {
  add_sequence_arguments(command, arguments.sequence, false);
  add_parameter_arguments(command, arguments.parameters);
  add_orientation_arguments(command, arguments.orientation);
  command.add_option("-o,--output", arguments.output, "Folder for the results, created if missing")
      ->capture_default_str()
      ->type_name("DIR");
  command.add_option("--backend", arguments.backend, "Where to compute; `plumbline backends` lists them")
      ->capture_default_str()
      ->type_name("NAME");
  command.add_option("--threads", arguments.threads, "CPU threads, 0 for all; the result does not depend on it")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str()
      ->type_name("N");
  command.add_option("--max-frames", arguments.max_frames, "Stop after so many frames, 0 for all")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str()
      ->type_name("N");
  command.add_option("--stride", arguments.stride, "Take every Nth frame")
      ->check(CLI::Range(1, 1 << 30))
      ->capture_default_str()
      ->type_name("N");
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
  command.add_flag("--no-mesh", arguments.no_mesh, "Do not extract and write the mesh");
  command.add_flag("--quiet", arguments.quiet, "Print nothing but errors");
  command.add_flag("--print-config", arguments.print_config, "Print every parameter with its value and help, and stop");
}

}  // namespace

void add_run_command(CLI::App& app, Command& chosen, const std::string& command_line) {
  const auto arguments = std::make_shared<RunArguments>();
  CLI::App* command = app.add_subcommand("run", "Reconstruct a sequence: trajectory, mesh and figures into a folder");
  add_options(*command, *arguments);
  command->footer(
      "Writes trajectory.txt, mesh.ply, frames.csv, config.toml and summary.json into DIR.\n"
      "Ctrl-C finishes the current frame and writes everything; the exit code is then 130.");
  arguments->command_line = command_line;
  command->callback([arguments, &chosen] { chosen = [arguments] { return run(*arguments); }; });
}

}  // namespace plumbline::app
