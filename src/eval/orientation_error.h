// How far estimated orientations are from the truth, as the BROAD benchmark counts it: D. Laidig, M. Caruso, A.
// Cereatti, T. Seel, "BROAD – a benchmark for robust inertial orientation estimation", Data 6(7), 2021.
#pragma once

#include <cstddef>
#include <vector>

#include "plumbline/orientation.h"
#include "plumbline/time.h"

namespace plumbline::eval {

/// Root mean squares, radians. Of the rotation between both, in earth axes: its whole angle, that of its twist about
/// the vertical (heading), and that of the rest, which is about a horizontal axis (inclination).
struct OrientationError {
  double total = 0, heading = 0, inclination = 0;
  std::size_t count = 0;  ///< of pairs
};

/// Each reference is compared with the estimate nearest in time, if that is within `tolerance`. Both ordered by time.
/// Throws Error if no stamps agree.
OrientationError orientation_error(const std::vector<OrientationSample>& reference,
                                   const std::vector<OrientationSample>& estimate, Nanoseconds tolerance = 1'000'000);

}  // namespace plumbline::eval
