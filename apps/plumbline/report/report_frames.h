// The frames of a run as columns of numbers: what the report's plots and its 3D view are drawn from.
#pragma once

#include <string>
#include <vector>

#include "run/reconstruction.h"

namespace plumbline::app {

/// `values` holds column after column, `rows` floats each; NaN = no such figure.
struct FrameTable {
  std::size_t rows = 0;
  int stride = 1;  ///< every so many frames of the run are in it
  std::vector<std::string> columns;
  std::vector<float> values;
};

/// The figures of frames.csv, and where the truth is known the true position (x, y, z, in the estimate's world after
/// the alignment) and the distance from it. At most 40 000 rows: longer runs are thinned.
FrameTable frame_table(const Reconstruction& run);

/// The true path between the first and the last frame, x y z after x y z, in the estimate's world; empty if unknown.
std::vector<float> true_path(const Reconstruction& run);

}  // namespace plumbline::app
