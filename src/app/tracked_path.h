// The camera's path through a sequence, by our own tracker from depth alone.
#pragma once

#include <string>

#include "core/frame.h"
#include "core/parameters.h"
#include "io/sequence.h"

namespace plumbline::app {

struct TrackingOptions {
  Parameters parameters;
  std::string backend = "auto";
  int threads = 0;     ///< 0 = all cores
  int max_frames = 0;  ///< 0 = all
  bool quiet = false;  ///< no progress
};

struct TrackedPath {
  Trajectory poses;  ///< of the frames that were tracked
  int frames = 0;    ///< that were processed
};

/// Throws Error for a frame that cannot be read, or if Ctrl-C was pressed.
TrackedPath track_path(const Sequence& sequence, const TrackingOptions& options);

}  // namespace plumbline::app
