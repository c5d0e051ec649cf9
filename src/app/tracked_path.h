// The camera's path through a sequence, by our own tracker from depth alone.
#pragma once

#include <optional>
#include <string>

#include "core/frame.h"
#include "core/parameters.h"
#include "io/sequence.h"
#include "tracking/depth_calibration.h"

namespace plumbline::app {

struct TrackingOptions {
  Parameters parameters;
  std::string backend = "auto";
  int threads = 0;     ///< 0 = all cores
  int max_frames = 0;  ///< 0 = all
  bool quiet = false;  ///< no progress
  /// Also find out how the depth is bent, and track it straightened: three passes instead of one.
  bool calibrate_depth = false;
};

struct TrackedPath {
  Trajectory poses;                                  ///< of the frames that were tracked
  int frames = 0;                                    ///< that were processed
  std::optional<DepthCalibrationResult> depth = {};  ///< what was taken out; nothing if it could not be told
};

/// Throws Error for a frame that cannot be read, or if Ctrl-C was pressed.
TrackedPath track_path(const Sequence& sequence, const TrackingOptions& options);

}  // namespace plumbline::app
