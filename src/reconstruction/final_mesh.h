// The mesh of the final fusion (docs/method.md §10), where one is wanted and possible.
#pragma once

#include "plumbline/fusion.h"
#include "plumbline/parameters.h"
#include "plumbline/reconstruct.h"
#include "reconstruction/frame_source.h"

namespace plumbline {

/// Fuses the accepted frames again along the run's path into `run->fusion`. Whatever keeps it from that (frames that
/// are gone, an interruption, too little memory) leaves a note. Of `options`, what follows from the run is filled in:
/// the range of depth, colour and what the surface is expected to need.
void fuse_finally(FusionOptions options, const FrameSource& source, Reconstruction* run);

}  // namespace plumbline
