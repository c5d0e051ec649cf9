// The camera's path through a sequence, by our own tracker from depth alone.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "calibration/depth_calibration.h"
#include "plumbline/parameters.h"
#include "plumbline/sequence.h"
#include "plumbline/trajectory.h"

namespace plumbline::app {

struct TrackingOptions {
  Parameters parameters;
  std::string backend = "auto";
  int threads = 0;     ///< 0 = all cores
  int max_frames = 0;  ///< 0 = all
  bool quiet = false;  ///< no progress
  /// Of track_path: also find out how the depth is bent, and track it straightened: two passes instead of one.
  bool calibrate_depth = false;
};

struct TrackedPath {
  Trajectory poses;                                  ///< of the frames that were tracked
  int frames = 0;                                    ///< that were processed
  std::optional<DepthCalibrationResult> depth = {};  ///< what was taken out; nothing if it could not be told
};

/// The tracker's path, drawn together by comparing frames that saw the same things (`DepthCalibration`). Throws Error
/// for a frame that cannot be read, or if Ctrl-C was pressed.
TrackedPath track_path(const Sequence& sequence, const TrackingOptions& options);

/// How the camera bends its depth, before a run over these frames of the sequence: two hundred of them, in pieces, are
/// tracked and compared. Nothing if they tell too little, or agree as well without. Throws as track_path does, or once
/// `stopping` says so. Of `options.parameters` only the range of depth counts: it is tracked by preset `plumbline`,
/// fast.
std::optional<DepthCalibrationResult> calibrate_depth(const Sequence& sequence, const std::vector<int>& frames,
                                                      const TrackingOptions& options,
                                                      const std::function<bool()>& stopping);

/// For `--depth-calibration FILE`. Throws Error if it cannot be written whole.
void save_depth_calibration(const std::string& path, const DepthCalibrationResult& found,
                            const std::string& command_line);

}  // namespace plumbline::app
