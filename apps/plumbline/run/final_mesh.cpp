#include "run/final_mesh.h"

#include <algorithm>
#include <chrono>
#include <new>
#include <vector>

#include "cli/progress.h"
#include "plumbline/error.h"
#include "plumbline/fusion.h"

namespace plumbline::app {
namespace {

/// m² of surface.
double area_of(const Mesh& mesh) {
  double area = 0;
  for (const Mesh::Triangle& t : mesh.triangles) {
    const auto corner = [&](std::uint32_t i) {
      const Mesh::Float3& p = mesh.positions[i];
      return Eigen::Vector3d(p.x, p.y, p.z);
    };
    area += 0.5 * (corner(t.b) - corner(t.a)).cross(corner(t.c) - corner(t.a)).norm();
  }
  return area;
}

/// Those that the run fused, at the poses of its path: none that is lost, or was at a place on trial.
std::vector<FusionFrame> accepted_frames(const Reconstruction& run) {
  std::vector<FusionFrame> frames;
  auto pose = run.trajectory.begin();
  for (const FrameReport& report : run.frames) {
    if (!has_pose(report.tracking.status)) continue;
    pose = std::find_if(pose, run.trajectory.end(), [&](const StampedPose& p) { return p.time == report.time; });
    if (pose == run.trajectory.end()) break;
    frames.push_back({report.index, pose->world_from_camera});
  }
  return frames;
}

FusionOptions fusion_options(const ReconstructionOptions& options, const std::function<bool()>& stopping,
                             const Mesh& coarse, Progress* progress) {
  FusionOptions fusion = options.fusion;
  fusion.preprocess = options.parameters.preprocess;
  fusion.color = options.input.color && options.parameters.volume.color;
  fusion.min_readings = std::max(options.fusion.min_readings, options.parameters.mesh.min_weight);
  fusion.expected_area = area_of(coarse);
  fusion.threads = options.threads;
  if (options.backend.starts_with("cpu")) fusion.backend = options.backend;
  fusion.stopping = stopping;
  fusion.on_progress = [progress](const FusionProgress& state) { progress->update(state.done, state.done, 0); };
  return fusion;
}

/// Why there is no fine mesh, or nothing.
std::string fuse(const ReconstructionOptions& options, const Sequence& recording, const std::function<bool()>& stopping,
                 Reconstruction* run) {
  const std::vector<FusionFrame> frames = accepted_frames(*run);
  Progress progress(static_cast<int>(frames.size()), options.quiet, {"frame", "fused again", "left out"});
  try {
    run->fusion = fuse_frames(recording, frames, fusion_options(options, stopping, run->mesh, &progress));
    if (!run->fusion) return stopping() ? "interrupted" : "no frame could be fused again";
  } catch (const std::bad_alloc&) {
    return "there is not enough memory; try --detail 8mm, or less --memory";
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace

void fuse_finally(const ReconstructionOptions& options, const FrameSource& source,
                  const std::function<bool()>& stopping, Reconstruction* run) {
  const auto start = std::chrono::steady_clock::now();
  if (const Sequence* recording = source.recording(); recording == nullptr)
    run->fusion_note = "the frames of a live camera cannot be read again";
  else if (stopping())
    run->fusion_note = "interrupted";
  else
    run->fusion_note = fuse(options, *recording, stopping, run);
  run->fusion_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace plumbline::app
