// The first piece of a run: what it reads from and computes with, opened before anything is written.
#pragma once

#include <memory>

#include "backend/backend.h"
#include "plumbline/pipeline.h"
#include "reconstruction/frame_source.h"
#include "reconstruction/run_parts.h"
#include "run/guided_source.h"
#include "run/reconstruction.h"

namespace plumbline::app {

struct OpenRun {
  std::unique_ptr<SensorStreams> sensor;  ///< of a recording's sensor, on the camera's clock
  std::unique_ptr<FrameSource> source;    ///< of `sensor`
  GuidedSource* guided = nullptr;         ///< the source, where a page watches
  std::shared_ptr<Backend> backend;
  std::unique_ptr<Pipeline> pipeline;  ///< of the backend
};

/// A pipeline for the run's frames; what an earlier one had is given back first.
void make_pipeline(const ReconstructionOptions& options, OpenRun* open);

/// Finds the distortion of the depth where the options want that. Fills in what is known of the run, and describes it
/// to the user. Throws Error for what cannot be opened or does not fit, or if Ctrl-C was pressed.
OpenRun open_run(const ReconstructionOptions& options, Reconstruction* run);

}  // namespace plumbline::app
