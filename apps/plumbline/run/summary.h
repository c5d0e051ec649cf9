// The figures of a run for programs (summary.json) and for people.
#pragma once

#include <string>
#include <vector>

#include "plumbline/trajectory.h"
#include "run/reconstruction.h"

namespace plumbline::app {

/// Medians over all frames, milliseconds.
struct StageMedians {
  double wait = 0, decode = 0, preprocess = 0, track = 0, integrate = 0, raycast = 0, total = 0;
};
StageMedians stage_medians(const Reconstruction& run);

/// Metres along the tracked trajectory.
double path_length(const Trajectory& trajectory);

/// JSON text of summary.json.
std::string summary_json(const Reconstruction& run);

/// A few lines: tracked and lost, accuracy where the truth is known, speed, memory.
std::vector<std::string> summary_text(const Reconstruction& run);

/// Peak resident memory of this process so far.
double peak_memory_mebibytes();

}  // namespace plumbline::app
