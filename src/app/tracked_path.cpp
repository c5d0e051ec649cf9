#include "app/tracked_path.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "app/interrupt.h"
#include "app/progress.h"
#include "backend/backend.h"
#include "core/error.h"
#include "io/prefetch.h"
#include "pipeline/pipeline.h"

namespace plumbline::app {
namespace {

// The second time the motions between frames are right from the start; a third one changes the path no more.
constexpr int kDepthRounds = 2;

class PathTracker {
 public:
  PathTracker(const Sequence& sequence, const TrackingOptions& options)
      : sequence_(sequence), options_(options), backend_(make_backend(options.backend, options.threads)) {}

  int frames() const {
    return options_.max_frames > 0 ? std::min(options_.max_frames, sequence_.size()) : sequence_.size();
  }
  Backend& backend() { return *backend_; }

  /// One pass. `calibration`, if there is one, gets the frames as they were measured.
  TrackedPath track(const DepthDistortion& distortion, DepthCalibration* calibration) {
    std::vector<int> indices(static_cast<std::size_t>(frames()));
    std::iota(indices.begin(), indices.end(), 0);
    Pipeline pipeline(options_.parameters, sequence_.info().camera, *backend_);
    Progress progress(frames(), options_.quiet);
    Prefetcher reader(sequence_, indices);
    TrackedPath path;
    while (std::optional<Frame> frame = reader.next()) {
      if (interrupt_.signal() != 0) throw Error("interrupted", sequence_.info().path, "");
      if (calibration != nullptr) calibration->add(*frame);
      distortion.correct(frame->depth_scale, &frame->depth);
      const FrameReport report = pipeline.process(*frame);
      ++path.frames;
      if (report.tracking.status != TrackingStatus::lost) path.poses.push_back({report.time, report.world_from_camera});
      const int tracked = static_cast<int>(path.poses.size());
      progress.update(path.frames, tracked, path.frames - tracked);
    }
    return path;
  }

 private:
  const Sequence& sequence_;
  const TrackingOptions& options_;
  std::unique_ptr<Backend> backend_;
  InterruptGuard interrupt_;
};

}  // namespace

TrackedPath track_path(const Sequence& sequence, const TrackingOptions& options) {
  PathTracker tracker(sequence, options);
  if (!options.calibrate_depth) return tracker.track({}, nullptr);
  DepthCalibration calibration(sequence.info().camera, options.parameters.preprocess, tracker.backend(),
                               tracker.frames());
  TrackedPath path = tracker.track({}, &calibration);
  for (int round = 0; round < kDepthRounds; ++round) {
    const std::optional<DepthCalibrationResult> found = calibration.estimate(path.poses);
    if (!found) break;
    path = tracker.track(found->distortion, nullptr);
    path.depth = found;
  }
  return path;
}

}  // namespace plumbline::app
