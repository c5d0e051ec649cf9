// Absolute and relative trajectory error, as the TUM RGB-D benchmark's tools define them (evaluate_ate.py,
// evaluate_rpe.py): Sturm, Engelhard, Endres, Burgard, Cremers, "A benchmark for the evaluation of RGB-D SLAM
// systems", IROS 2012.
//
// Trajectories need not be ordered by time here; indices in the results are those of the trajectories given.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "plumbline/export.h"
#include "plumbline/se3.h"
#include "plumbline/statistics.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"

namespace plumbline::eval {

struct AssociationOptions {
  Nanoseconds max_difference = 20'000'000;  ///< stamps must differ by less
  Nanoseconds offset = 0;                   ///< added to the estimate's stamps
};

struct Association {
  std::size_t reference = 0, estimate = 0;  ///< indices
};

/// One-to-one pairs of poses, closest stamps first (ties: the earlier reference pose, then the earlier estimate),
/// ordered by the reference's time. O(n log n) in the number of poses. May be empty.
PLUMBLINE_EXPORT std::vector<Association> associate(const Trajectory& reference, const Trajectory& estimate,
                                                    const AssociationOptions& options = {});

struct AbsoluteError {
  struct Pair {
    std::size_t reference = 0, estimate = 0;  ///< indices
    double translation = 0;                   ///< metres, after the alignment
  };
  Statistics translation;       ///< metres
  SE3 reference_from_estimate;  ///< the alignment: reference ≈ reference_from_estimate * estimate
  std::vector<Pair> pairs;      ///< ordered by the reference's time
};

/// Positions compared after the rigid alignment, without scale, that is best in the least-squares sense (Horn 1987,
/// Umeyama 1991). Throws Error where fewer than 3 poses can be associated (saying how far the clocks are apart) or a
/// pose is not finite.
PLUMBLINE_EXPORT AbsoluteError absolute_trajectory_error(const Trajectory& reference, const Trajectory& estimate,
                                                         const AssociationOptions& options = {});

enum class DeltaUnit { seconds, metres, radians, frames };

struct RelativeErrorOptions {
  bool all_pairs = false;               ///< every pair of poses; otherwise pairs `delta` apart
  double delta = 1;                     ///< in `unit`, measured along the estimate
  DeltaUnit unit = DeltaUnit::seconds;  ///< of `delta`
  std::size_t max_pairs = 10000;        ///< more are thinned at random; 0 = no limit
  std::uint64_t seed = 1;               ///< of the thinning
  Nanoseconds offset = 0;               ///< added to the estimate's stamps
};

struct RelativeError {
  struct Pair {
    std::size_t estimate_first = 0, estimate_second = 0, reference_first = 0, reference_second = 0;  ///< indices
    double translation = 0;                                                                          ///< metres
    double rotation = 0;                                                                             ///< radians
  };
  Statistics translation;  ///< metres per pair
  Statistics rotation;     ///< radians per pair
  std::vector<Pair> pairs;
};

/// Difference of the relative motions over pairs of poses; needs no alignment. Each estimated pose takes the reference
/// pose nearest in time, and a pair counts where both lie within twice the reference's median interval. As in the
/// benchmark's tool, a pair whose second pose is the estimate's last is left out for a fixed delta (its end was cut
/// off), and all pairs include a pose with itself. Throws Error where fewer than 2 pairs remain (saying how far the
/// clocks are apart), a pose is not finite, or the options are out of range.
PLUMBLINE_EXPORT RelativeError relative_trajectory_error(const Trajectory& reference, const Trajectory& estimate,
                                                         const RelativeErrorOptions& options = {});

}  // namespace plumbline::eval
