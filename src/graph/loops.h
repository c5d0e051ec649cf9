// Views of a path that show the same place at different times, each pair registered and tested alone.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "graph/edges.h"
#include "graph/odometry.h"
#include "graph/views.h"
#include "plumbline/loops.h"

namespace plumbline {

/// Of the median of χ² over 6 that is to be expected from six directions with the right covariance.
constexpr double kMedianChi2 = 0.891;

/// What the covariances of registrations are to be multiplied by, from what neighbours on the path disagree by with the
/// motion between them that was tracked: neighbouring pixels are not independent, by how much depends on the scene.
double covariance_scale(const std::vector<PathView>& views, const std::vector<std::optional<ViewEdge>>& neighbours);

/// Whether the registration stands by itself, whatever the path says: known in all directions, the same both ways, and
/// no surface where the other view looked through. `accepted` if so.
LoopStatus judge_alone(const ViewEdge& edge, double scale);

/// The same beside the path: `too_far` where that cannot have drifted by as much.
LoopStatus judge(const ViewEdge& edge, const Odometry& odometry, double scale);

struct LoopPair {
  std::size_t first, second;  ///< of the views
};
/// Pairs that may show one place although the path was elsewhere in between: of each view those before it that are
/// near it, as far as the path can have drifted, and among those the ones that look most like it.
std::vector<LoopPair> loop_candidates(const std::vector<PathView>& views);

struct TriedLoop {
  LoopPair pair;
  LoopStatus status = LoopStatus::not_registered;
  std::optional<ViewEdge> edge;
};

/// Adds the candidates that were not accepted yet: registered from where `views` are, tested alone, against the path,
/// and all against each other. Nothing is left once `stopping` returns true.
void find_loops(const std::vector<PathView>& views, const Odometry& odometry, double scale, ViewMatcher* matcher,
                const std::function<bool()>& stopping, std::vector<TriedLoop>* loops);

}  // namespace plumbline
