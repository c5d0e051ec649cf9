#include "plumbline/reconstruct.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <utility>

#include "backend/backend.h"
#include "io/atomic_file.h"
#include "io/mesh.h"
#include "io/wrapped_sequence.h"
#include "plumbline/config.h"
#include "plumbline/error.h"
#include "plumbline/files.h"
#include "reconstruction/final_mesh.h"
#include "reconstruction/path_correction.h"
#include "reconstruction/run_parts.h"

namespace plumbline {
namespace {

/// Tells the caller of each frame.
class Listener : public FrameObserver {
 public:
  explicit Listener(const ReconstructOptions& options) : options_(options) {}
  void observe(const ProcessedFrame& processed) override {
    if (options_.on_frame) options_.on_frame(processed.frame, processed.report);
  }

 private:
  const ReconstructOptions& options_;
};

std::vector<int> checked_frames(const Sequence& sequence, const std::vector<int>& frames) {
  if (frames.empty()) return chosen_frames(sequence, 0);
  const bool ascending = std::adjacent_find(frames.begin(), frames.end(), std::greater_equal<>()) == frames.end();
  if (!ascending || frames.front() < 0 || frames.back() >= sequence.size())
    throw Error("the frames are not indices of the sequence in ascending order", sequence.info().path,
                "Give indices from 0 to " + std::to_string(sequence.size() - 1) + ", each once.");
  return frames;
}

void tell(const ReconstructOptions& options, LogLevel level, const std::string& line) {
  if (options.log) options.log(level, line);
}

/// The caller's sequence, which stays the caller's; its info is the run's.
std::unique_ptr<Sequence> borrowed(const Sequence& sequence, const std::string& unused) {
  SequenceInfo info = sequence.info();
  if (!unused.empty()) info.notes.push_back(unused);
  return std::make_unique<WrappedSequence>(std::shared_ptr<const Sequence>(std::shared_ptr<void>(), &sequence),
                                           std::move(info));
}

void tell_beginning(const ReconstructOptions& options, const SensorReadings& sensor, const Reconstruction& run) {
  for (const Warning& warning : run.sequence.warnings) tell(options, LogLevel::warning, warning.what);
  for (const std::string& note : run.sequence.notes) tell(options, LogLevel::note, note);
  if (sensor.orientation) tell(options, LogLevel::note, "orientation: " + sensor.source);
  for (const std::string& note : sensor.notes) tell(options, LogLevel::note, note);
  if (run.depth) tell(options, LogLevel::note, run.depth->distortion.describe() + " was found and is taken out");
  if (!run.depth_refusal.empty()) tell(options, LogLevel::note, depth_refusal_text(run.depth_refusal));
  if (run.clock) tell(options, LogLevel::note, run.clock->text);
}

FusionOptions fusion_options(const ReconstructOptions& options) {
  FusionOptions fusion = options.fusion;
  fusion.color = fusion.color && options.color;
  fusion.threads = options.threads;
  fusion.backend = options.backend;
  if (options.stopping) fusion.stopping = options.stopping;
  return fusion;
}

}  // namespace

Reconstruction reconstruct(const Sequence& given, const ReconstructOptions& options) {
  validate(options.parameters);
  const std::vector<int> frames = checked_frames(given, options.frames);
  const SensorReadings sensor = options.sensor ? *options.sensor : recorded_sensor(given);
  if (options.sensor && sensor.orientation) check_overlap(*sensor.orientation, given, sensor.source);
  const auto stopping = [&] { return options.stopping && options.stopping(); };

  Reconstruction run;
  run.parameters = options.parameters;
  run.orientation = sensor.source;
  run.orientation_notes = sensor.notes;
  std::unique_ptr<Sequence> sequence = borrowed(given, sensor.unused);
  const CalibrationOptions calibration{
      .parameters = options.parameters, .backend = options.backend, .threads = options.threads, .stopping = stopping};
  if (options.parameters.preprocess.calibrate_depth)
    sequence = undistort_depth(std::move(sequence), frames, calibration, &run);
  SensorStreams streams{sensor.orientation, sensor.inertial};
  set_clock(*sequence, frames, calibration, &streams, &run);
  FileSource source(std::move(sequence), frames, streams.orientation ? &*streams.orientation : nullptr, {},
                    streams.inertial ? &*streams.inertial : nullptr);
  run.sequence = source.info();
  const std::shared_ptr<Backend> backend = make_backend(options.backend, options.threads);
  run.backend = backend->description();
  tell_beginning(options, sensor, run);
  const std::unique_ptr<Pipeline> pipeline =
      make_pipeline(options.parameters, source, *backend, options.initial_pose, options.color, sensor.sensor);
  Listener listener(options);
  process_frames(source, *pipeline,
                 {{&listener}, stopping, [&](const std::string& line) { tell(options, LogLevel::warning, line); }},
                 &run);
  correct_path({options.global, stopping}, source, *backend, &run);
  take_surface(*pipeline, options.mesh, &run);
  if (options.mesh && options.final_fusion) fuse_finally(fusion_options(options), source, &run);
  if (run.fusion) run.mesh = std::exchange(run.fusion->mesh, {});
  return run;
}

void write_reconstruction(const std::string& folder, const Reconstruction& run) {
  ensure_directory(folder);
  const auto path = [&](const char* name) { return (std::filesystem::path(folder) / name).string(); };
  write_tum_trajectory(path("trajectory.txt"), run.trajectory);
  if (!run.live_trajectory.empty()) write_tum_trajectory(path("trajectory_live.txt"), run.live_trajectory);
  if (!run.mesh.triangles.empty()) write_ply(path("mesh.ply"), run.mesh);
  write_file(path("config.toml"), to_toml(run.parameters));
  if (run.depth)
    write_depth_calibration(path("depth.toml"), run.depth->distortion,
                            depth_calibration_comments(*run.depth, "plumbline::reconstruct"));
}

}  // namespace plumbline
