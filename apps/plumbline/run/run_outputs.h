// The final piece of a run: the files in its output folder.
#pragma once

#include <string>

#include "cli/interrupt.h"
#include "run/frame_log.h"
#include "run/open_run.h"
#include "run/reconstruction.h"

namespace plumbline::app {

/// Path of a file in the output folder.
std::string output_path(const ReconstructionOptions& options, const std::string& name);

/// False for a run that never registered one frame to another: it has nothing to replace older results with.
bool is_worth_writing(const Reconstruction& run);

/// Writes everything that was reached, completes `run` by mesh and evaluation, and tells the user. After
/// an interruption there is no final fusion, and none goes on. Throws Error if a file cannot be written; a report that
/// cannot be written is a warning.
void write_outputs(const ReconstructionOptions& options, const OpenRun& open, const InterruptGuard& interrupt,
                   FrameLog* log, Reconstruction* run);

}  // namespace plumbline::app
