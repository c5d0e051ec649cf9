// By how much the clocks of two trajectories seem to differ.
#pragma once

#include <cstddef>

#include "plumbline/time.h"
#include "plumbline/trajectory.h"

namespace plumbline::eval {

struct TimeOffsetOptions {
  Nanoseconds range = 200'000'000;  ///< searched to both sides of `offset`; positive
  Nanoseconds offset = 0;           ///< added to the estimate's stamps already
};

struct TimeOffset {
  Nanoseconds best = 0;        ///< to be added to the estimate's stamps, `options.offset` included
  double rmse = 0;             ///< metres, with `best`
  double rmse_as_given = 0;    ///< metres, with `options.offset`
  std::size_t poses = 0;       ///< that were compared
  bool at_the_border = false;  ///< of the range: the best may lie beyond it
};

/// The offset with the smallest absolute trajectory error. Every candidate is judged on the same poses (those whose
/// surroundings of ± range the reference covers, thinned to 20000) with the reference interpolated linearly, so the
/// errors are comparable with each other but not to the last digit with absolute_trajectory_error(), which takes the
/// nearest pose. Searched in steps of 1/40 of the range or at most 10 ms, then to 10 µs by golden section.
/// Trajectories are ordered by time. Throws Error where fewer than 3 poses can be compared or the range is not
/// positive.
TimeOffset best_time_offset(const Trajectory& reference, const Trajectory& estimate,
                            const TimeOffsetOptions& options = {});

}  // namespace plumbline::eval
