#include "run/run_outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "cli/console.h"
#include "eval/similarity.h"
#include "io/atomic_file.h"
#include "io/mesh.h"
#include "io/trajectory.h"
#include "plumbline/calibration.h"
#include "plumbline/config.h"
#include "plumbline/error.h"
#include "plumbline/orientation_calibration.h"
#include "reconstruction/path_correction.h"
#include "reconstruction/run_parts.h"
#include "run/final_mesh.h"
#include "run/summary.h"

namespace plumbline::app {
namespace {

namespace fs = std::filesystem;

std::optional<std::string> inverse_text(const Reconstruction& run) {
  const auto error = eval::error_if_inverted(run.trajectory, run.truth);
  if (!error) return std::nullopt;
  return fmt::format(
      "with its poses inverted, the truth would lie within {:.4f} m (rmse) of the path: they seem to be "
      "camera_from_world "
      "where world_from_camera is meant",
      *error);
}

/// A truth that is inverted or in another unit says nothing of the path's error: it is not used. Any other factor is
/// the depth scale's.
void check_truth_scale(Reconstruction* run) {
  constexpr double kAlike = 1.15, kMuchBetter = 0.5, kMaxFactor = 10;
  if (const auto text = inverse_text(*run)) {
    run->ate_note = *text;
    run->ate.reset();
    return;
  }
  const double factor = eval::similarity_scale(run->truth, run->trajectory);
  if (!(factor > 0) || (factor < kAlike && factor > 1 / kAlike)) return;
  const auto fitted = eval::absolute_trajectory_error(run->truth, eval::scaled(run->trajectory, factor));
  if (fitted.translation.rmse > kMuchBetter * run->ate->translation.rmse) return;
  for (const auto& [per_metre, unit] : {std::pair(1000.0, "millimetres"), {100.0, "centimetres"}})
    if (factor / per_metre > 0.5 && factor / per_metre < 2) {
      run->ate_note = fmt::format(
          "the true path is {:.0f} times as long as the tracked one: its positions seem to be in "
          "{} where metres are expected",
          factor, unit);
      run->ate.reset();
      return;
    }
  if (factor > kMaxFactor || factor < 1 / kMaxFactor) return;
  run->ate_note = fmt::format(
      "multiplied by {:.3g} the path would lie within {:.4f} m (rmse) of the truth: the depth scale may be wrong, "
      "{:.4g} readings a metre where {:.4g} were taken",
      factor, fitted.translation.rmse, run->sequence.depth_scale / factor, run->sequence.depth_scale);
}

void evaluate(Reconstruction* run) {
  if (run->truth.empty()) return;
  try {
    run->ate = eval::absolute_trajectory_error(run->truth, run->trajectory);
    check_truth_scale(run);
  } catch (const Error& error) {
    if (!run->ate) run->ate_note = error.what();
  }
}

/// A file of an earlier run would tell of that one.
void remove_older(const std::string& path) {
  std::error_code ignored;
  fs::remove(path, ignored);
}

void write_meshes(const ReconstructionOptions& options, const Mesh& mesh) {
  write_ply(output_path(options, "mesh.ply"), mesh);
  for (const std::string& name : options.mesh_files) write_mesh(output_path(options, name), mesh);
}

/// Replaces the volume's, which stays where this one cannot be made or written whole.
void write_fused_mesh(const ReconstructionOptions& options, const FrameSource& source, const InterruptGuard& interrupt,
                      Reconstruction* run) {
  fuse_with_progress(
      options, source, [&] { return interrupt.signal() != 0; }, run);
  run->signal = interrupt.signal();
  if (!run->fusion) return;
  if (run->crop) run->fusion->mesh = cropped(run->fusion->mesh, *run->crop);
  try {
    write_meshes(options, run->fusion->mesh);
    run->mesh = std::exchange(run->fusion->mesh, {});
  } catch (const Error& error) {
    run->fusion_note = error.what();
    run->fusion.reset();
  }
}

/// The file of the trajectory is that of the tracked one until the corrected one is whole.
void correct_and_write_path(const ReconstructionOptions& options, const OpenRun& open, const InterruptGuard& interrupt,
                            Reconstruction* run) {
  const std::string live = output_path(options, "trajectory_live.txt");
  correct_path({options.global, [&] { return interrupt.signal() != 0; }}, *open.source, *open.backend, run);
  run->signal = interrupt.signal();
  if (run->live_trajectory.empty()) return remove_older(live);
  write_tum_trajectory(live, run->live_trajectory);
  write_tum_trajectory(output_path(options, "trajectory.txt"), run->trajectory);
}

/// For other recordings of this camera.
void write_depth(const std::string& path, const Reconstruction& run) {
  if (!run.depth) return remove_older(path);
  write_depth_calibration(path, run.depth->distortion, depth_calibration_comments(*run.depth, run.command_line));
}

/// For other recordings of this camera with this sensor: mounting, and the clock's offset that was found.
void write_sensor(const std::string& path, const OpenRun& open, const Reconstruction& run) {
  if (!run.clock || run.clock->offset == 0 || !open.sensor->orientation) return remove_older(path);
  const OrientationStreamOptions& stream = open.sensor->orientation->options();
  write_orientation_calibration(path,
                                {.body_from_camera = stream.body_from_camera,
                                 .time_offset = stream.time_offset,
                                 .time_offset_sd = run.clock->sd,
                                 .convention = stream.convention},
                                {"For `plumbline run --orientation-calibration FILE`; the mounting is the one that was "
                                 "given, the offset was found by",
                                 run.command_line});
}

/// Never what a run fails for: the other files hold all that is in the page.
void write_page(const ReconstructionOptions& options, Reconstruction* run) {
  const std::string path = output_path(options, "report.html");
  try {
    if (options.report && options.write_report) {
      options.write_report(path, *run);
      run->report = path;
      return;
    }
  } catch (const std::exception& error) {
    warn(fmt::format("there is no report of this run; its other files are whole\n  {}", error.what()));
  }
  remove_older(path);
}

void say_summary(const ReconstructionOptions& options, const Reconstruction& run) {
  for (const std::string& line : summary_text(run)) say(line);
  if (!run.report.empty()) say("report     {}", run.report);
  if (options.report && !options.write_report)
    say("report     none: this program was built without it (PLUMBLINE_REPORT)");
}

}  // namespace

std::string output_path(const ReconstructionOptions& options, const std::string& name) {
  return (fs::path(options.output) / name).string();
}

bool is_worth_writing(const Reconstruction& run) {
  if (run.signal != 0) return !run.trajectory.empty();
  const bool alone = run.frames.size() == 1 && !run.trajectory.empty();
  return alone || std::any_of(run.frames.begin(), run.frames.end(), [](const FrameReport& frame) {
           return frame.tracking.status == TrackingStatus::tracked;
         });
}

void write_outputs(const ReconstructionOptions& options, const OpenRun& open, const InterruptGuard& interrupt,
                   FrameLog* log, Reconstruction* run) {
  // The trajectory first: it is the smallest, and what a full disk should spare.
  write_tum_trajectory(output_path(options, "trajectory.txt"), run->trajectory);
  correct_and_write_path(options, open, interrupt, run);
  evaluate(run);
  take_surface(*open.pipeline, options.mesh, run);
  if (options.view) run->crop = options.view->crop();
  if (run->crop) run->mesh = cropped(run->mesh, *run->crop);
  if (options.mesh) write_meshes(options, run->mesh);
  write_file(output_path(options, "config.toml"), to_toml(options.parameters));
  write_depth(output_path(options, "depth.toml"), *run);
  write_sensor(output_path(options, "sensor.toml"), open, *run);
  log->commit();
  if (options.mesh && options.final_fusion) write_fused_mesh(options, *open.source, interrupt, run);
  write_file(output_path(options, "summary.json"), summary_json(*run));
  write_page(options, run);
  if (!options.quiet) say_summary(options, *run);
}

}  // namespace plumbline::app
