// The drift of a run's path, corrected where the camera came back (docs/method.md §12).
#pragma once

#include "backend/backend.h"
#include "graph/close_loops.h"
#include "plumbline/loops.h"
#include "plumbline/parameters.h"
#include "plumbline/reconstruct.h"
#include "reconstruction/frame_source.h"

namespace plumbline {

/// Whether the path is corrected with these parameters at all.
bool corrects_path(GlobalCorrection correction, const Parameters& parameters);

/// Reads frames of the recording again and corrects the run's path and the poses of its frames, where that is wanted
/// and pays; `run->loops` says what was found, or what kept it from that (a live camera, an interruption). What was
/// tracked stays in `run->live_trajectory`.
void correct_path(const LoopOptions& options, const FrameSource& source, const Backend& backend, Reconstruction* run);

}  // namespace plumbline
