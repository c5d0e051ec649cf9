// Figures of what commands leave in files: a run's frames, the iterations of a frame, the angular test.
#pragma once

#include <string>
#include <vector>

#include "report/plot.h"

namespace plumbline::app {

/// Matched pixels, distances, seed to result, and time, over the frames of a frames.csv. Throws Error for another
/// table.
Plot frames_plot(const std::string& csv_path);

/// The distribution of the distances at every iteration of a frame (`run --dump-icp`), a panel for each level, and
/// how their median and the residual fall. Throws Error for another file.
Plot iterations_plot(const std::string& json_path);

/// Failures, and errors of the successes, over the angle between two frames, for each `angles --csv`; `with_paper` adds
/// the published curves. Throws Error for another table.
Plot angles_plot(const std::vector<std::string>& csv_paths, const std::vector<std::string>& names, bool with_paper);

}  // namespace plumbline::app
