// The final fusion of a run, with its progress shown.
#pragma once

#include <functional>

#include "reconstruction/frame_source.h"
#include "run/reconstruction.h"

namespace plumbline::app {

/// As `plumbline::fuse_finally`, with the options of the command.
void fuse_with_progress(const ReconstructionOptions& options, const FrameSource& source,
                        const std::function<bool()>& stopping, Reconstruction* run);

}  // namespace plumbline::app
