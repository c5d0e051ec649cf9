#include "reconstruction/run_parts.h"

#include <fmt/format.h>

#include <chrono>
#include <exception>
#include <new>
#include <utility>

#include "plumbline/error.h"
#include "plumbline/time.h"
#include "reconstruction/orientation_check.h"
#include "reconstruction/run_record.h"
#include "sensor/orientation_filter.h"

namespace plumbline {
namespace {

/// Runs `finish` however the scope is left.
template <class Finish>
struct AtEnd {
  Finish finish;
  ~AtEnd() { finish(); }
};

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// With `seconds` added to all stamps.
OrientationStream shifted(const OrientationStream& stream, double seconds) {
  std::vector<OrientationSample> samples = stream.samples();
  OrientationStreamOptions options = stream.options();
  for (OrientationSample& sample : samples) sample.time -= from_seconds(options.time_offset);
  options.time_offset += seconds;
  return {std::move(samples), options};
}

/// By the gyroscope alone, which no filter delays.
OrientationStream turns_of(const ImuStream& inertial) {
  ImuRecording recording;
  recording.samples = inertial.samples();
  return {integrated_turns(recording), {}};
}

ImuStream shifted(const ImuStream& stream, double seconds) {
  ImuRecording recording;
  recording.samples = stream.samples();
  return {std::move(recording), Eigen::Matrix3d::Identity(), seconds};
}

}  // namespace

void set_clock(const Sequence& sequence, const std::vector<int>& frames, const CalibrationOptions& options,
               SensorStreams* sensor, Reconstruction* run) {
  if (!sensor->orientation) return;
  const OrientationStreamOptions& stream = sensor->orientation->options();
  const OrientationParameters& orientation = options.parameters.orientation;
  const bool is_aimed = orientation.seed != OrientationSeed::none || orientation.term != OrientationTerm::none;
  const bool is_used = orientation.distrust > 0 && (sensor->inertial ? options.parameters.motion.gyroscope : is_aimed);
  if (!is_used || stream.time_offset != 0 || !stream.convention.has_heading) return;
  const auto start = std::chrono::steady_clock::now();
  try {
    run->clock = find_clock_offset(sequence, frames,
                                   sensor->inertial ? turns_of(*sensor->inertial) : *sensor->orientation, options);
  } catch (const std::exception&) {
    return;
  }
  run->clock->seconds = seconds_since(start);
  if (run->clock->offset == 0) return;
  sensor->orientation = shifted(*sensor->orientation, run->clock->offset);
  if (sensor->inertial) sensor->inertial = shifted(*sensor->inertial, run->clock->offset);
}

std::string depth_refusal_text(const std::string& refusal) {
  return "distortion of the depth looked for and not found, because " + refusal;
}

std::unique_ptr<Sequence> undistort_depth(std::unique_ptr<Sequence> sequence, const std::vector<int>& frames,
                                          const CalibrationOptions& options, Reconstruction* run) {
  const auto start = std::chrono::steady_clock::now();
  try {
    run->depth = calibrate_depth(*sequence, frames, options, &run->depth_refusal);
  } catch (const std::exception& error) {
    run->depth.reset();
    run->depth_refusal = error.what();
  }
  run->depth_seconds = seconds_since(start);
  if (!run->depth) return sequence;
  return without_depth_distortion(std::move(sequence), run->depth->distortion);
}

std::unique_ptr<Pipeline> make_pipeline(const Parameters& parameters, const FrameSource& source, Backend& backend,
                                        const SE3& initial_pose, bool with_color, const OrientationSensor& sensor) {
  const bool color = with_color && source.has_color() && parameters.volume.color;
  try {
    return std::make_unique<Pipeline>(parameters, source.info().camera, backend, initial_pose, color, sensor);
  } catch (const std::bad_alloc&) {
    throw Error("there is not enough memory for " + volume_text(parameters.volume), "volume.resolution",
                "Make it smaller, for example --set volume.resolution=256.");
  }
}

std::string volume_text(const VolumeParameters& volume) {
  const int resolution = (volume.resolution + 7) / 8 * 8;
  return fmt::format("{0}x{0}x{0} voxels of {1:.2f} mm, side {2:g} m, truncation {3:g} m{4}", resolution,
                     1e3 * volume.side / resolution, volume.side, volume.truncation,
                     volume.placement == VolumePlacement::follow ? ", moves with the camera" : "");
}

void process_frames(FrameSource& source, Pipeline& pipeline, const RunHooks& hooks, Reconstruction* run) {
  RunRecord record(run);
  OrientationObserver orientation(source.orientation(), hooks.note);
  std::vector<FrameObserver*> observers = {&record, &orientation};
  observers.insert(observers.end(), hooks.observers.begin(), hooks.observers.end());
  const AtEnd end{[&] {
    record.take_back();
    run->orientation_message = orientation.message();
    run->skipped = source.skipped();
  }};
  run_frames(source, pipeline, observers, hooks.stopping, hooks.note);
}

void take_surface(const Pipeline& pipeline, bool with_mesh, Reconstruction* run) {
  run->consistency = pipeline.check_consistency();
  run->world_from_volume = pipeline.world_from_volume();
  run->volume_side = pipeline.volume_side();
  if (with_mesh) run->mesh = pipeline.extract_mesh();
}

}  // namespace plumbline
