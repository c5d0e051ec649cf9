#include "run/open_run.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "cli/console.h"
#include "cli/interrupt.h"
#include "cli/orientation_arguments.h"
#include "cli/sequence_text.h"
#include "io/atomic_file.h"
#include "io/trajectory.h"
#include "io/wrapped_sequence.h"
#include "plumbline/calibration.h"
#include "plumbline/config.h"
#include "plumbline/error.h"
#include "reconstruction/run_parts.h"
#include "run/realtime_source.h"

namespace plumbline::app {
namespace {

/// A camera that plays in real time is not known beforehand.
bool is_to_be_calibrated(const ReconstructionOptions& options) {
  return options.parameters.preprocess.calibrate_depth && options.input.depth_distortion.empty() &&
         options.realtime == 0;
}

/// What a recording tells before it is run: the distortion of its depth, which is taken out, and the sensor's clock.
std::unique_ptr<Sequence> calibrated(std::unique_ptr<Sequence> sequence, const std::vector<int>& frames,
                                     const ReconstructionOptions& options, SensorStreams* sensor, Reconstruction* run) {
  const InterruptGuard interrupt;
  const CalibrationOptions calibration{
      .parameters = options.parameters, .backend = options.backend, .threads = options.threads, .stopping = [&] {
        return interrupt.signal() != 0;
      }};
  if (is_to_be_calibrated(options)) sequence = undistort_depth(std::move(sequence), frames, calibration, run);
  if (options.realtime == 0) set_clock(*sequence, frames, calibration, sensor, run);
  if (interrupt.signal() != 0) throw Error("interrupted before the first frame was through", options.sequence, "");
  return sequence;
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

std::vector<std::string> description(const Sequence& sequence, const ReconstructionOptions& options) {
  std::vector<std::string> lines = describe(sequence);
  if (!options.orientation) return lines;
  for (std::string& line : describe(*options.orientation, options.orientation_source, options.orientation_notes,
                                    options.parameters.orientation))
    lines.push_back(std::move(line));
  return lines;
}

/// `in_real_time`: where the options want that. `sensor` must outlive the source.
std::unique_ptr<FrameSource> frames_of(const std::shared_ptr<const Sequence>& sequence, std::vector<int> frames,
                                       bool in_real_time, const ReconstructionOptions& options,
                                       const SensorStreams& sensor) {
  auto files =
      std::make_unique<FileSource>(std::make_unique<WrappedSequence>(sequence, sequence->info()), std::move(frames),
                                   sensor.orientation ? &*sensor.orientation : nullptr, description(*sequence, options),
                                   sensor.inertial ? &*sensor.inertial : nullptr);
  if (options.realtime == 0 || !in_real_time) return files;
  return std::make_unique<RealtimeSource>(std::move(files), options.realtime);
}

std::unique_ptr<FrameSource> open_files(const ReconstructionOptions& options, SensorStreams* sensor,
                                        Reconstruction* run) {
  std::unique_ptr<Sequence> sequence = open_noted(options);
  read_own_groundtruth(*sequence, options, run);
  std::vector<int> frames =
      frames_outside(*sequence, options.left_out, chosen_frames(*sequence, options.max_frames, options.stride));
  if (frames.empty()) throw Error("all frames are left out", "--leave-out", "Leave out less than the whole recording.");
  sequence = calibrated(std::move(sequence), frames, options, sensor, run);
  const Reopen reopen = [shared = std::shared_ptr<const Sequence>(std::move(sequence)), &options, sensor](
                            std::vector<int> chosen, bool in_real_time) {
    return frames_of(shared, std::move(chosen), in_real_time, options, *sensor);
  };
  std::unique_ptr<FrameSource> source = reopen(frames, true);
  if (!options.view) return source;
  return std::make_unique<GuidedSource>(std::move(source), reopen, std::move(frames), options.view.get());
}

std::unique_ptr<FrameSource> open_camera(const ReconstructionOptions& options) {
  std::unique_ptr<FrameSource> source = options.open_live();
  if (!options.view) return source;
  return std::make_unique<GuidedSource>(std::move(source), Reopen(), std::vector<int>(), options.view.get());
}

void introduce(const ReconstructionOptions& options, const Reconstruction& run, OpenRun* open) {
  if (!options.view) return;
  open->guided = static_cast<GuidedSource*>(open->source.get());
  const std::string name = std::filesystem::path(run.sequence.path).lexically_normal().filename().string();
  options.view->set_scene({.title = name.empty() ? run.sequence.path : name,
                           .camera = run.sequence.camera,
                           .total = open->source->total(),
                           .is_live = options.open_live != nullptr,
                           .max_depth = options.parameters.preprocess.max_depth,
                           .output = options.output});
}

void load_groundtruth(const std::string& path, Reconstruction* run) {
  run->groundtruth = path.empty() ? run->sequence.groundtruth : path;
  if (!path.empty()) run->truth = read_trajectory(path);
}

void describe_run(const ReconstructionOptions& options, const FrameSource& source, const Reconstruction& run) {
  for (const std::string& line : source.describe()) say(line);
  if (run.depth)
    say("depth      its distortion was found in {:.1f} s, from {} pairs of frames", run.depth_seconds,
        run.depth->pairs);
  if (!run.depth_refusal.empty()) say("depth      {}", depth_refusal_text(run.depth_refusal));
  if (run.clock) say("clock      {}; looked for in {:.1f} s", run.clock->text, run.clock->seconds);
  say("volume     {}", volume_text(options.parameters.volume));
  say("backend    {}", run.backend);
  say("output     {}", options.output);
}

}  // namespace

void make_pipeline(const ReconstructionOptions& options, OpenRun* open) {
  if (options.view) options.view->follow(nullptr);
  open->pipeline.reset();
  open->pipeline = plumbline::make_pipeline(options.parameters, *open->source, *open->backend, options.initial_pose,
                                            options.input.color, options.sensor);
  if (options.view) options.view->follow(open->pipeline.get());
}

OpenRun open_run(const ReconstructionOptions& options, Reconstruction* run) {
  validate(options.parameters);
  OpenRun open;
  open.sensor = std::make_unique<SensorStreams>(SensorStreams{options.orientation, options.inertial});
  open.source = options.open_live ? open_camera(options) : open_files(options, open.sensor.get(), run);
  open.backend = make_backend(options.backend, options.threads);
  run->sequence = open.source->info();
  run->parameters = options.parameters;
  run->command_line = options.command_line;
  run->backend = open.backend->description();
  run->orientation = options.orientation_source;
  run->orientation_notes = options.orientation_notes;
  load_groundtruth(options.groundtruth, run);
  ensure_directory(options.output);
  introduce(options, *run, &open);
  make_pipeline(options, &open);
  if (!options.quiet) describe_run(options, *open.source, *run);
  return open;
}

}  // namespace plumbline::app
