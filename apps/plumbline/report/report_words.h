// What came of a run, in words and in the figures that are read first.
#pragma once

#include <string>
#include <vector>

#include "run/reconstruction.h"

namespace plumbline::app {

struct Verdict {
  enum class Level { none, good, fair, poor };
  Level level = Level::none;
  std::string text;  ///< a sentence
};

struct Fact {
  std::string label, value, note;
};

/// Good: every frame was tracked, and the path is within 5 cm (rmse) of the truth where that is known. Poor: more than
/// a tenth of the frames were lost, the path is more than 20 cm off, or the run broke off.
Verdict verdict_of(const Reconstruction& run);

/// Which frames were lost and why, what became of the sensor's readings, whether the truth is known.
std::vector<std::string> remarks_of(const Reconstruction& run);

/// Frames, error, path, time, mesh, memory.
std::vector<Fact> facts_of(const Reconstruction& run);

/// Command, sequence, camera, volume, backend, versions.
std::vector<Fact> details_of(const Reconstruction& run);

/// "12 345".
std::string grouped(std::size_t number);

}  // namespace plumbline::app
