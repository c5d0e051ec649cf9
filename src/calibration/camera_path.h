// Frames of a recording tracked for a calibration.
#pragma once

#include <memory>
#include <vector>

#include "backend/backend.h"
#include "calibration/depth_calibration.h"
#include "plumbline/calibration.h"
#include "plumbline/depth_distortion.h"
#include "plumbline/sequence.h"

namespace plumbline {

/// For paths that are roughly right: preset `plumbline`, quality `fast`, within this range of depth.
Parameters fast_parameters(const PreprocessParameters& range);

/// Passes over frames of one sequence, each with its own pipeline.
class PathTracker {
 public:
  /// Both must outlive it.
  PathTracker(const Sequence& sequence, const CalibrationOptions& options);

  const Backend& backend() const { return *backend_; }

  /// One pass, with `distortion` taken out of the depth. `calibration`, if there is one, gets the frames as they were
  /// measured. Throws Error for a frame that cannot be read, or once `options.stopping` returns true.
  CameraPath track(const std::vector<int>& frames, const DepthDistortion& distortion, DepthCalibration* calibration);

 private:
  const Sequence& sequence_;
  const CalibrationOptions& options_;
  std::shared_ptr<Backend> backend_;
  int pass_ = 0;
};

}  // namespace plumbline
