// The drift of a recording's path, corrected where the camera came back (docs/method.md §12).
#pragma once

#include <functional>
#include <vector>

#include "backend/backend.h"
#include "graph/views.h"
#include "plumbline/loops.h"
#include "plumbline/parameters.h"
#include "plumbline/se3.h"
#include "plumbline/sequence.h"

namespace plumbline {

struct LoopOptions {
  GlobalCorrection correction = GlobalCorrection::automatic;
  std::function<bool()> stopping = {};  ///< asked before each view; true leaves the path as it is
};

struct ClosedLoops {
  LoopClosure report;
  std::vector<SE3> world_from_camera;  ///< a pose a frame of the path; empty if nothing is corrected
};

/// Reads some frames of the recording again, looks for places that were seen more than once, and spreads what they
/// disagree by over the path. The same bits for any number of threads. Throws Error if most of the frames cannot be
/// read.
ClosedLoops close_loops(const Sequence& recording, const std::vector<PathFrame>& path, const Parameters& parameters,
                        const Backend& backend, const LoopOptions& options);

/// Poses between the views, moved by what the views on both sides are moved by, in proportion to the way; beyond the
/// first and the final one as those are.
std::vector<SE3> spread_correction(const std::vector<PathFrame>& path, const std::vector<std::size_t>& frames,
                                   const std::vector<SE3>& world_from_view);

}  // namespace plumbline
