// The mesh of a run: that of its volume, and that of the final fusion where one is wanted and possible.
#pragma once

#include <functional>

#include "plumbline/pipeline.h"
#include "run/frame_source.h"
#include "run/reconstruction.h"

namespace plumbline::app {

/// Fuses the accepted frames again along the run's path into `run->fusion`. Whatever keeps it from that (frames that
/// are gone, an interruption, too little memory) leaves a note.
void fuse_finally(const ReconstructionOptions& options, const FrameSource& source,
                  const std::function<bool()>& stopping, Reconstruction* run);

}  // namespace plumbline::app
