// What the stages of a frame take in a run: the run's own loop over frames held in memory.
#pragma once

#include <string>

#include "lab/stages.h"
#include "plumbline/parameters.h"
#include "plumbline/pipeline.h"

namespace plumbline::app {

/// Medians over the tracked frames of a run that plays `frames` to and fro, so that the camera moves from each frame to
/// the next: once through, and on for `seconds` altogether. Throws Error if no frame is tracked.
StageTimes run_stage_times(const StageFrames& frames, const Parameters& parameters, const std::string& backend,
                           int threads, double seconds);

/// Of one of `StageScene::stages()` that is whole.
double milliseconds_of(const StageTimes& times, const std::string& stage);

}  // namespace plumbline::app
