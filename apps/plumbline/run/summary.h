// The figures of a run for programs (summary.json) and for people.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "plumbline/loops.h"
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

/// Where the run was interrupted, and what came of it.
struct Interruptions {
  int count = 0;      ///< times that nothing linked a frame to the previous accepted one
  int recovered = 0;  ///< times that a known place was recognised
  int revoked = 0;    ///< of these, not confirmed: the frames after it contradicted it, or there were none
};
Interruptions interruptions(const Reconstruction& run);

/// Seconds after the start from which on no frame shows a known place; none if the run ends otherwise.
std::optional<double> lost_to_the_end(const Reconstruction& run);

/// Of the places that were seen again, how many are accepted, and why others are not.
std::string loops_words(const LoopClosure& loops);

/// JSON text of summary.json.
std::string summary_json(const Reconstruction& run);

/// A few lines: tracked and lost, accuracy where the truth is known, speed, memory.
std::vector<std::string> summary_text(const Reconstruction& run);

/// Peak resident memory of this process so far.
double peak_memory_mebibytes();

}  // namespace plumbline::app
