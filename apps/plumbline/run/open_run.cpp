#include "run/open_run.h"

#include <fmt/format.h>

#include <chrono>
#include <exception>
#include <new>
#include <utility>

#include "cli/console.h"
#include "cli/interrupt.h"
#include "cli/orientation_arguments.h"
#include "io/atomic_file.h"
#include "io/trajectory.h"
#include "io/wrapped_sequence.h"
#include "plumbline/calibration.h"
#include "plumbline/config.h"
#include "plumbline/error.h"
#include "run/realtime_source.h"

namespace plumbline::app {
namespace {

std::string volume_text(const VolumeParameters& volume) {
  const int resolution = (volume.resolution + 7) / 8 * 8;
  return fmt::format("{0}x{0}x{0} voxels of {1:.2f} mm, side {2:g} m, truncation {3:g} m", resolution,
                     1e3 * volume.side / resolution, volume.side, volume.truncation);
}

/// A camera that plays in real time is not known beforehand.
bool is_to_be_calibrated(const ReconstructionOptions& options) {
  return options.parameters.preprocess.calibrate_depth && options.input.depth_distortion.empty() &&
         options.realtime == 0;
}

/// What cannot be read here is told by the run, which keeps all that came before it.
void find_depth_distortion(const Sequence& sequence, const std::vector<int>& frames,
                           const ReconstructionOptions& options, Reconstruction* run) {
  const auto start = std::chrono::steady_clock::now();
  const InterruptGuard interrupt;
  const CalibrationOptions calibration{
      .parameters = options.parameters, .backend = options.backend, .threads = options.threads, .stopping = [&] {
        return interrupt.signal() != 0;
      }};
  try {
    run->depth = calibrate_depth(sequence, frames, calibration);
  } catch (const std::exception&) {
    if (interrupt.signal() != 0) throw Error("interrupted before the first frame was through", options.sequence, "");
  }
  run->depth_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::unique_ptr<Sequence> open_noted(const ReconstructionOptions& options) {
  std::shared_ptr<const Sequence> sequence = options.opened;
  if (!sequence) sequence = open_sequence(options.sequence, options.input);
  SequenceInfo info = sequence->info();
  if (!options.unused.empty()) info.notes.push_back(options.unused);
  return std::make_unique<WrappedSequence>(std::move(sequence), std::move(info));
}

/// A damaged companion file is no reason not to reconstruct.
void read_own_groundtruth(const Sequence& sequence, const ReconstructionOptions& options, Reconstruction* run) {
  if (!options.groundtruth.empty()) return;
  try {
    run->truth = sequence.read_groundtruth();
  } catch (const Error& error) {
    run->ate_note = error.what();
  }
}

std::unique_ptr<FrameSource> open_files(const ReconstructionOptions& options, Reconstruction* run) {
  std::unique_ptr<Sequence> sequence = open_noted(options);
  read_own_groundtruth(*sequence, options, run);
  std::vector<int> frames =
      frames_outside(*sequence, options.left_out, chosen_frames(*sequence, options.max_frames, options.stride));
  if (frames.empty()) throw Error("all frames are left out", "--leave-out", "Leave out less than the whole recording.");
  if (is_to_be_calibrated(options)) find_depth_distortion(*sequence, frames, options, run);
  if (run->depth) sequence = without_depth_distortion(std::move(sequence), run->depth->distortion);
  std::vector<std::string> lines;
  if (options.orientation)
    lines = describe(*options.orientation, options.orientation_source, options.orientation_notes,
                     options.parameters.orientation);
  auto files = std::make_unique<FileSource>(std::move(sequence), std::move(frames),
                                            options.orientation ? &*options.orientation : nullptr, std::move(lines),
                                            options.inertial ? &*options.inertial : nullptr);
  if (options.realtime == 0) return files;
  return std::make_unique<RealtimeSource>(std::move(files), options.realtime);
}

void load_groundtruth(const std::string& path, Reconstruction* run) {
  run->groundtruth = path.empty() ? run->sequence.groundtruth : path;
  if (!path.empty()) run->truth = read_trajectory(path);
}

std::unique_ptr<Pipeline> make_pipeline(const ReconstructionOptions& options, const FrameSource& source,
                                        Backend& backend) {
  const bool color = options.input.color && source.has_color() && options.parameters.volume.color;
  try {
    return std::make_unique<Pipeline>(options.parameters, source.info().camera, backend, options.initial_pose, color,
                                      options.sensor);
  } catch (const std::bad_alloc&) {
    throw Error("there is not enough memory for " + volume_text(options.parameters.volume), "volume.resolution",
                "Make it smaller, for example --set volume.resolution=256.");
  }
}

void describe_run(const ReconstructionOptions& options, const FrameSource& source, const Reconstruction& run) {
  for (const std::string& line : source.describe()) say(line);
  if (run.depth)
    say("depth      its distortion was found in {:.1f} s, from {} pairs of frames", run.depth_seconds,
        run.depth->pairs);
  say("volume     {}", volume_text(options.parameters.volume));
  say("backend    {}", run.backend);
  say("output     {}", options.output);
}

}  // namespace

OpenRun open_run(const ReconstructionOptions& options, Reconstruction* run) {
  validate(options.parameters);
  OpenRun open;
  open.source = options.open_live ? options.open_live() : open_files(options, run);
  open.backend = make_backend(options.backend, options.threads);
  run->sequence = open.source->info();
  run->parameters = options.parameters;
  run->command_line = options.command_line;
  run->backend = open.backend->description();
  run->orientation = options.orientation_source;
  run->orientation_notes = options.orientation_notes;
  load_groundtruth(options.groundtruth, run);
  ensure_directory(options.output);
  open.pipeline = make_pipeline(options, *open.source, *open.backend);
  if (!options.quiet) describe_run(options, *open.source, *run);
  return open;
}

}  // namespace plumbline::app
