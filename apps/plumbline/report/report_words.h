// What came of a run, in words and in the figures that are read first.
#pragma once

#include <string>
#include <vector>

#include "run/reconstruction.h"
#include "run/verdict.h"

namespace plumbline::app {

struct Fact {
  std::string label, value, note;
};

/// Which frames were lost and why, what became of the sensor's readings, whether the truth is known.
std::vector<std::string> remarks_of(const Reconstruction& run);

/// Frames, error, path, time, mesh, memory.
std::vector<Fact> facts_of(const Reconstruction& run);

/// Command, sequence, camera, volume, backend, versions.
std::vector<Fact> details_of(const Reconstruction& run);

/// "12 345".
std::string grouped(std::size_t number);

}  // namespace plumbline::app
