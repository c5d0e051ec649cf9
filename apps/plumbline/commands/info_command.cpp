#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>

#include "cli/commands.h"
#include "cli/console.h"
#include "cli/sequence_arguments.h"
#include "cli/sequence_text.h"
#include "io/images/png.h"
#include "io/imu_file.h"
#include "plumbline/error.h"

namespace plumbline::app {
namespace {

/// Readings that cannot be read are no reason not to tell of the frames; where a copy is wanted, they are an error.
ImuRecording readable_imu(const Sequence& sequence, bool must_be, std::vector<std::string>* notes) {
  try {
    return sequence.read_imu(notes);
  } catch (const Error& error) {
    if (must_be) throw;
    say("note       the inertial sensor is not used: {}", error.what());
    return {};
  }
}

/// The inertial readings beside the frames, and a copy of them on request.
void show_imu(const Sequence& sequence, const std::string& copy) {
  std::vector<std::string> notes;
  const ImuRecording imu = readable_imu(sequence, !copy.empty(), &notes);
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

/// Depth (near is bright, grey; no reading is blue) and colour of the middle frame that can be read, side by side.
void write_picture(const Sequence& sequence, const std::string& path) {
  Frame frame;
  for (int i = sequence.size() / 2; frame.depth.empty(); ++i) try {
      frame = sequence.read(i);
    } catch (const Error&) {
      if (i + 1 >= sequence.size()) throw;
    }
  const DepthImage& depth = frame.depth;
  const int sides = frame.color.empty() ? 1 : 2;
  ColorImage picture(sides * depth.width, depth.height, 3);
  for (int y = 0; y < depth.height; ++y)
    for (int x = 0; x < depth.width; ++x) {
      const double metres = depth.at(x, y) / frame.depth_scale;
      const auto grey = static_cast<std::uint8_t>(std::clamp(255 * std::exp(-metres / 4), 20.0, 255.0));
      for (int c = 0; c < 3; ++c) {
        picture.at(x, y, c) = metres > 0 ? grey : static_cast<std::uint8_t>(c == 2 ? 120 : 0);
        if (sides == 2) picture.at(depth.width + x, y, c) = frame.color.at(x, y, c);
      }
    }
  write_color_png(path, picture);
  say("picture    {}, of frame {}", path, frame.index);
}

int show_info(const SequenceArguments& arguments, const std::string& imu_copy, const std::string& picture) {
  const auto sequence = open_sequence(arguments.path, sequence_options(arguments));
  for (const std::string& line : describe(*sequence)) say(line);
  const Timing times = timing(*sequence);
  if (times.median_interval > 0)
    say("intervals  {:.1f} ms (median), longest {:.3f} s, {:.2f} s after the start", 1e3 * times.median_interval,
        times.longest_gap, times.longest_gap_start);
  show_imu(*sequence, imu_copy);
  if (!picture.empty()) write_picture(*sequence, picture);
  return 0;
}

}  // namespace

void add_info_command(CLI::App& app, Command& chosen) {
  const auto arguments = std::make_shared<SequenceArguments>();
  CLI::App* command = app.add_subcommand("info", "Tell what a sequence holds and what would be assumed about it");
  add_sequence_arguments(*command, *arguments, true);
  const auto imu_copy = std::make_shared<std::string>();
  command->add_option("--imu", *imu_copy, "Write the inertial sensor's raw readings there, as csv")->type_name("FILE");
  const auto picture = std::make_shared<std::string>();
  command->add_option("--picture", *picture, "Write depth and colour of a frame there, side by side")
      ->type_name("FILE");
  command->callback([arguments, imu_copy, picture, &chosen] {
    chosen = [arguments, imu_copy, picture] { return show_info(*arguments, *imu_copy, *picture); };
  });
}

}  // namespace plumbline::app
