#include "reconstruction/path_correction.h"

#include <cstddef>
#include <utility>
#include <vector>

#include "plumbline/error.h"

namespace plumbline {
namespace {

/// The run's frames that have a pose, and where they stand in its list of frames.
struct RunPath {
  std::vector<PathFrame> frames;
  std::vector<std::size_t> reports;
};

/// A reading that was trusted, by what the tracker did with it.
std::optional<Eigen::Vector3d> up_in_camera(const FrameReport& report, const FrameSource& source) {
  if (report.orientation != OrientationUse::used && report.orientation != OrientationUse::first) return std::nullopt;
  const std::optional<Eigen::Matrix3d> earth_from_camera = source.earth_from_camera(report.time);
  if (!earth_from_camera) return std::nullopt;
  return Eigen::Vector3d(earth_from_camera->row(2).transpose());
}

RunPath path_of(const Reconstruction& run, const FrameSource& source) {
  RunPath path;
  auto pose = run.trajectory.begin();
  for (std::size_t i = 0; i < run.frames.size() && pose != run.trajectory.end(); ++i) {
    const FrameReport& report = run.frames[i];
    if (report.tracking.status == TrackingStatus::lost || report.time != pose->time) continue;
    path.frames.push_back({report.index, pose->world_from_camera, report.is_recovered, up_in_camera(report, source)});
    path.reports.push_back(i);
    ++pose;
  }
  return path;
}

void take_corrected(const RunPath& path, const std::vector<SE3>& world_from_camera, Reconstruction* run) {
  run->live_trajectory = run->trajectory;
  for (std::size_t i = 0; i < world_from_camera.size(); ++i) {
    run->trajectory[i].world_from_camera = world_from_camera[i];
    run->frames[path.reports[i]].world_from_camera = world_from_camera[i];
  }
}

}  // namespace

bool corrects_path(GlobalCorrection correction, const Parameters& parameters) {
  return correction == GlobalCorrection::on ||
         (correction == GlobalCorrection::automatic && parameters.tracking.relocalise_after > 0);
}

void correct_path(const LoopOptions& options, const FrameSource& source, const Backend& backend, Reconstruction* run) {
  if (!corrects_path(options.correction, run->parameters)) return;
  run->loops.emplace();
  const Sequence* recording = source.recording();
  if (recording == nullptr) {
    run->loops->note = "the frames of a live camera cannot be read again";
    return;
  }
  const RunPath path = path_of(*run, source);
  try {
    ClosedLoops closed = close_loops(*recording, path.frames, run->parameters, backend, options);
    run->loops = std::move(closed.report);
    if (!closed.world_from_camera.empty()) take_corrected(path, closed.world_from_camera, run);
  } catch (const Error& error) {
    run->loops->note = error.what();
  }
}

}  // namespace plumbline
