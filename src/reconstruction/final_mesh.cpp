#include "reconstruction/final_mesh.h"

#include <algorithm>
#include <chrono>
#include <new>
#include <vector>

#include "fusion/mesh_cleanup.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

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

/// Why there is no fine mesh, or nothing.
std::string fuse(const FusionOptions& options, const Sequence& recording, Reconstruction* run) {
  try {
    run->fusion = fuse_frames(recording, accepted_frames(*run), options);
    if (!run->fusion) return options.stopping && options.stopping() ? "interrupted" : "no frame could be fused again";
  } catch (const std::bad_alloc&) {
    return "there is not enough memory; try --detail 8mm, or less --memory";
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace

void fuse_finally(FusionOptions options, const FrameSource& source, Reconstruction* run) {
  const auto start = std::chrono::steady_clock::now();
  options.preprocess = run->parameters.preprocess;
  options.color = options.color && run->parameters.volume.color;
  options.min_readings = std::max(options.min_readings, run->parameters.mesh.min_weight);
  options.expected_area = area_of(run->mesh);
  if (const Sequence* recording = source.recording(); recording == nullptr)
    run->fusion_note = "the frames of a live camera cannot be read again";
  else if (options.stopping && options.stopping())
    run->fusion_note = "interrupted";
  else
    run->fusion_note = fuse(options, *recording, run);
  run->fusion_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace plumbline
