#include "app/tracked_path.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <optional>
#include <vector>

#include "app/interrupt.h"
#include "app/progress.h"
#include "backend/backend.h"
#include "core/error.h"
#include "io/prefetch.h"
#include "pipeline/pipeline.h"

namespace plumbline::app {

TrackedPath track_path(const Sequence& sequence, const TrackingOptions& options) {
  const int count = options.max_frames > 0 ? std::min(options.max_frames, sequence.size()) : sequence.size();
  std::vector<int> indices(static_cast<std::size_t>(count));
  std::iota(indices.begin(), indices.end(), 0);
  const std::unique_ptr<Backend> backend = make_backend(options.backend, options.threads);
  Pipeline pipeline(options.parameters, sequence.info().camera, *backend);
  const InterruptGuard interrupt;
  Progress progress(count, options.quiet);
  Prefetcher reader(sequence, indices);
  TrackedPath path;
  while (const std::optional<Frame> frame = reader.next()) {
    if (interrupt.signal() != 0) throw Error("interrupted", sequence.info().path, "");
    const FrameReport report = pipeline.process(*frame);
    ++path.frames;
    if (report.tracking.status != TrackingStatus::lost) path.poses.push_back({report.time, report.world_from_camera});
    const int tracked = static_cast<int>(path.poses.size());
    progress.update(path.frames, tracked, path.frames - tracked);
  }
  return path;
}

}  // namespace plumbline::app
