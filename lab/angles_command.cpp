#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "backend/backend.h"
#include "cli/arguments.h"
#include "cli/backend_arguments.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/orientation_arguments.h"
#include "cli/parameter_arguments.h"
#include "cli/sequence_arguments.h"
#include "cli/sequence_text.h"
#include "eval/turned_pairs.h"
#include "io/atomic_file.h"
#include "io/trajectory.h"
#include "lab/angular_report.h"
#include "lab/angular_test.h"
#include "plumbline/angles.h"
#include "plumbline/config.h"
#include "plumbline/error.h"
#include "plumbline/se3.h"

namespace plumbline::app {
namespace {

struct AnglesArguments {
  SequenceArguments sequence;
  ParameterArguments parameters;
  OrientationArguments orientation;
  std::string backend = "auto", groundtruth, json, csv;
  std::vector<double> angles = {5, 10, 15, 20, 25, 30, 40, 50, 60};  // degrees
  int pairs = 20, threads = 0;
  double tolerance = 1;                                                            // degrees
  double max_translation = 0.25;                                                   // metres
  double success_translation = SuccessLimits{}.translation, success_rotation = 1;  // metres, degrees
  std::string command_line;
};

/// Depth is all that the test looks at.
std::unique_ptr<Sequence> open_depth(const SequenceArguments& arguments) {
  SequenceOptions options = sequence_options(arguments);
  options.color = false;
  return open_sequence(arguments.path, options);
}

std::string groundtruth_of(const Sequence& sequence, const AnglesArguments& arguments) {
  if (!arguments.groundtruth.empty()) return arguments.groundtruth;
  if (sequence.info().groundtruth.empty())
    throw Error("there is no ground truth, and the test needs the true poses", arguments.sequence.path,
                "Put a groundtruth.txt into the folder, or give a file with --groundtruth.");
  return sequence.info().groundtruth;
}

AngularReport report_on(const AnglesArguments& arguments) {
  AngularReport report;
  report.command_line = arguments.command_line;
  report.sequence = arguments.sequence.path;
  report.preset = arguments.parameters.preset;
  report.orientation = describe(arguments.orientation);
  report.pairs_wanted = arguments.pairs;
  report.tolerance = arguments.tolerance;
  report.max_translation = arguments.max_translation;
  report.limits = {arguments.success_translation, radians(arguments.success_rotation)};
  return report;
}

/// Each row as soon as it is known.
std::vector<AngleResult> run_angles(const AnglesArguments& arguments, const AngularTest& test,
                                    const std::vector<std::optional<SE3>>& poses) {
  eval::TurnedPairOptions options;
  options.tolerance = radians(arguments.tolerance);
  options.max_translation = arguments.max_translation;
  options.count = static_cast<std::size_t>(arguments.pairs);
  std::vector<AngleResult> results;
  for (const double degrees : arguments.angles) {
    options.angle = radians(degrees);
    results.push_back(test.run(degrees, eval::turned_pairs(poses, options), poses));
    say(table_row(results.back()));
    flush_output();
  }
  return results;
}

void say_what_was_missing(const AnglesArguments& arguments, const std::vector<AngleResult>& results) {
  int fewer = 0, missing = 0;
  for (const AngleResult& result : results) {
    const AngleSummary summary = summarise(result);
    fewer += summary.pairs < arguments.pairs;
    missing += summary.missing;
  }
  if (fewer > 0)
    say("note       the sequence has fewer than {} pairs for {} of the {} angles", arguments.pairs, fewer,
        results.size());
  if (missing > 0) say("note       {} pairs have no reading of the orientation sensor", missing);
}

/// A file that was asked for, begun before the test so that a path that cannot be written costs no time.
class OutputFile {
 public:
  explicit OutputFile(const std::string& path) {
    if (!path.empty()) file_.emplace(path);
  }
  void write(const std::string& text) {
    if (!file_) return;
    file_->write(text);
    file_->commit();
  }

 private:
  std::optional<AtomicFile> file_;
};

int angles(const AnglesArguments& arguments) {
  const Parameters parameters = effective_parameters(arguments.parameters);
  const OrientationSensor sensor = {.covariance = sensor_covariance(arguments.orientation)};
  validate(parameters);
  const SensorReadings readings = load_orientation(arguments.orientation);
  const std::optional<OrientationStream>& orientation = readings.orientation;
  if (orientation && !orientation->options().convention.has_heading)
    throw UsageError("has the tilt only, where the test needs the whole orientation", "--orientation",
                     "Give a file with headings.");
  AngularReport report = report_on(arguments);
  const std::unique_ptr<Sequence> sequence = open_depth(arguments.sequence);
  report.frames = sequence->size();
  report.groundtruth = groundtruth_of(*sequence, arguments);
  const auto poses = true_poses(*sequence, read_trajectory(report.groundtruth), report.groundtruth);
  const std::shared_ptr<Backend> backend = make_backend(arguments.backend, arguments.threads);
  report.backend = backend->description();
  OutputFile json(arguments.json), csv(arguments.csv);

  for (const std::string& line : describe(*sequence)) say(line);
  if (orientation)
    for (const std::string& line : describe(*orientation, report.orientation, readings.notes, parameters.orientation))
      say(line);
  say("backend    {}", report.backend);
  say("success    tracked, and within {:g} m and {:g}° of the true pose", arguments.success_translation,
      arguments.success_rotation);
  say("\n{}", table_header());
  const AngularTest test(*sequence, parameters, *backend, orientation ? &*orientation : nullptr, report.limits, sensor);
  report.angles = run_angles(arguments, test, poses);
  say("errors: median of the successes\n");
  for (const std::string& line : paper_rows()) say(line);
  say_what_was_missing(arguments, report.angles);
  json.write(angular_json(report));
  csv.write(pairs_csv(report.angles));
  return 0;
}

void add_test_options(CLI::App& command, AnglesArguments& a) {
  command.add_option("--angles", a.angles, "Degrees between the frames of a pair")
      ->delimiter(',')
      ->check(CLI::Range(0.1, 180.0))
      ->capture_default_str();
  command.add_option("--pairs", a.pairs, "Of frames, for each angle")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str()
      ->type_name("N");
  const auto number = [&](const char* name, double& value, const char* help, double low, double high,
                          const char* type) {
    command.add_option(name, value, help)->check(CLI::Range(low, high))->capture_default_str()->type_name(type);
  };
  number("--tolerance", a.tolerance, "How far a pair's true angle may be from the one asked for", 1e-6, 90, "DEG");
  number("--max-translation", a.max_translation, "Farthest that the true positions of a pair lie apart", 0, 1e3, "M");
  number("--success-translation", a.success_translation, "Largest error of a success", 1e-6, 1e3, "M");
  number("--success-rotation", a.success_rotation, "Largest error of a success", 1e-6, 180, "DEG");
}

void add_options(CLI::App& command, AnglesArguments& a) {
  add_sequence_arguments(command, a.sequence, true);
  add_test_options(command, a);
  add_parameter_arguments(command, a.parameters);
  add_orientation_arguments(command, a.orientation);
  command.add_option("--groundtruth", a.groundtruth, "True trajectory (default: the sequence's own)")
      ->type_name("FILE");
  add_backend_arguments(command, a.backend, a.threads);
  command.add_option("--json", a.json, "Write the table and what it was made with")->type_name("FILE");
  command.add_option("--csv", a.csv, "Write a row for each pair")->type_name("FILE");
}

}  // namespace

void add_angles_command(CLI::App& app, Command& chosen, const std::string& command_line) {
  const auto arguments = std::make_shared<AnglesArguments>();
  CLI::App* command = app.add_subcommand("angles", "The angular test: how large a turn between two frames is tracked");
  add_options(*command, *arguments);
  command->footer(
      "For each angle, pairs of frames are chosen by the ground truth, spread over the sequence and as near to each\n"
      "other as there are; `plumbline simulate --turn DEG` makes sequences of nothing else. The first frame of a pair\n"
      "starts a reconstruction, the second is registered to it.");
  arguments->command_line = command_line;
  command->callback([arguments, &chosen] { chosen = [arguments] { return angles(*arguments); }; });
}

}  // namespace plumbline::app
