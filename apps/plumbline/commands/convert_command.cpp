#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "cli/commands.h"
#include "cli/console.h"
#include "cli/interrupt.h"
#include "cli/sequence_arguments.h"
#include "cli/sequence_text.h"
#include "io/atomic_file.h"
#include "io/images/png.h"
#include "io/imu_file.h"
#include "io/recorded_camera.h"
#include "io/trajectory.h"
#include "plumbline/error.h"
#include "plumbline/prefetch.h"

namespace plumbline::app {
namespace {

namespace fs = std::filesystem;

void write_text(const fs::path& path, const std::string& text) {
  AtomicFile file(path.string());
  file.write(text);
  file.commit();
}

/// The lists of a TUM folder, line by line.
struct Lists {
  std::string depth = "# timestamp filename\n", color = "# timestamp filename\n";
  int frames = 0, color_frames = 0;
};

void write_frame(const fs::path& folder, const Frame& frame, Lists* lists) {
  const std::string stamp = format_seconds(frame.time, 9);
  write_depth_png((folder / "depth" / (stamp + ".png")).string(), frame.depth);
  lists->depth += fmt::format("{0} depth/{0}.png\n", stamp);
  ++lists->frames;
  if (frame.color.empty()) return;
  write_color_png((folder / "rgb" / (stamp + ".png")).string(), frame.color);
  lists->color += fmt::format("{0} rgb/{0}.png\n", stamp);
  ++lists->color_frames;
}

/// Truth and readings of the inertial sensor, where there are some; what cannot be read is told.
void write_companions(const fs::path& folder, const Sequence& sequence) {
  try {
    const Trajectory truth = sequence.read_groundtruth();
    if (!truth.empty()) write_tum_trajectory((folder / "groundtruth.txt").string(), truth);
    if (!truth.empty()) say("truth      {} poses", truth.size());
  } catch (const Error& error) {
    say("note       the true poses are not used, because {}", error.what());
  }
  try {
    const ImuRecording imu = sequence.read_imu();
    if (!imu.samples.empty()) write_imu((folder / "imu.csv").string(), imu);
    if (!imu.samples.empty()) say("imu        {} samples", imu.samples.size());
  } catch (const Error& error) {
    say("note       the inertial sensor is not used, because {}", error.what());
  }
}

int convert(const SequenceArguments& arguments, const std::string& output) {
  const auto sequence = open_sequence(arguments.path, sequence_options(arguments));
  for (const std::string& line : describe(*sequence)) say(line);
  const fs::path folder = output;
  if (fs::exists(folder / "depth.txt"))
    throw Error("holds a sequence already", output, "give a new folder with -o, or remove the old one");
  ensure_directory((folder / "depth").string());
  if (sequence->info().color_frames > 0) ensure_directory((folder / "rgb").string());
  std::vector<int> indices;
  for (int i = 0; i < sequence->size(); ++i) indices.push_back(i);
  const InterruptGuard interrupt;
  ReadableFrames frames(*sequence, indices);
  Lists lists;
  while (const auto frame = frames.next()) {
    if (interrupt.signal() != 0) throw Error("interrupted; the folder is not complete", output, "");
    write_frame(folder, *frame, &lists);
  }
  for (const std::string& reason : frames.skipped()) say("note       frame skipped: {}", reason);
  const SequenceInfo& info = sequence->info();
  write_camera_json(output, info.camera, info.depth_scale, info.body_from_camera);  // the folder needs no options
  write_companions(folder, *sequence);
  if (lists.color_frames > 0) write_text(folder / "rgb.txt", lists.color);
  write_text(folder / "depth.txt", lists.depth);
  say("written    {}: {} frames, {} with colour", output, lists.frames, lists.color_frames);
  return 0;
}

}  // namespace

void add_convert_command(CLI::App& app, Command& chosen) {
  const auto arguments = std::make_shared<SequenceArguments>();
  const auto output = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand("convert", "Write a recording of any kind as a TUM RGB-D folder");
  add_sequence_arguments(*command, *arguments, true);
  command->add_option("-o,--output", *output, "Folder to write")->required()->type_name("DIR");
  command->callback(
      [arguments, output, &chosen] { chosen = [arguments, output] { return convert(*arguments, *output); }; });
}

}  // namespace plumbline::app
