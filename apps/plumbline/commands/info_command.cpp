#include <CLI/CLI.hpp>
#include <memory>

#include "cli/commands.h"
#include "cli/console.h"
#include "cli/sequence_arguments.h"
#include "cli/sequence_text.h"
#include "io/imu_file.h"
#include "plumbline/error.h"

namespace plumbline::app {
namespace {

/// The inertial readings beside the frames, and a copy of them where that is asked for.
void show_imu(const Sequence& sequence, const std::string& copy) {
  std::vector<std::string> notes;
  const ImuRecording imu = sequence.read_imu(&notes);
  if (imu.samples.empty()) {
    if (!copy.empty()) throw Error("has no readings of an inertial sensor", sequence.info().path, "leave --imu out");
    return;
  }
  for (const std::string& line : describe(imu, sequence.info())) say(line);
  for (const std::string& note : notes) say("note       {}", note);
  if (copy.empty()) return;
  write_imu(copy, imu);
  say("written    {}", copy);
}

int show_info(const SequenceArguments& arguments, const std::string& imu_copy) {
  const auto sequence = open_sequence(arguments.path, sequence_options(arguments));
  for (const std::string& line : describe(*sequence)) say(line);
  const Timing times = timing(*sequence);
  if (times.median_interval > 0)
    say("intervals  {:.1f} ms (median), longest {:.3f} s, {:.2f} s after the start", 1e3 * times.median_interval,
        times.longest_gap, times.longest_gap_start);
  show_imu(*sequence, imu_copy);
  return 0;
}

}  // namespace

void add_info_command(CLI::App& app, Command& chosen) {
  const auto arguments = std::make_shared<SequenceArguments>();
  CLI::App* command = app.add_subcommand("info", "Tell what a sequence holds and what would be assumed about it");
  add_sequence_arguments(*command, *arguments, true);
  const auto imu_copy = std::make_shared<std::string>();
  command->add_option("--imu", *imu_copy, "Write the inertial sensor's raw readings there, as csv")->type_name("FILE");
  command->callback(
      [arguments, imu_copy, &chosen] { chosen = [arguments, imu_copy] { return show_info(*arguments, *imu_copy); }; });
}

}  // namespace plumbline::app
