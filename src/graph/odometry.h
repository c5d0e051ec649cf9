// How well the tracked path knows the motion between any two of its views.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "graph/edges.h"
#include "graph/views.h"

namespace plumbline {

/// a_from_c with the covariance that follows from both parts, which err independently.
RelativePose compose(const RelativePose& a_from_b, const RelativePose& b_from_c);

/// The tracked motions from view to view, each with what it may be wrong by: as much as a registration of the two views
/// may, and by what the two disagree. Across a cut of the path and where nothing could be registered, a guess that is
/// wide.
class Odometry {
 public:
  /// `neighbours`: of each view with the next, one fewer than there are views. `scale`: of their covariances.
  Odometry(const std::vector<PathView>& views, const std::vector<std::optional<ViewEdge>>& neighbours, double scale);

  const std::vector<RelativePose>& steps() const { return steps_; }
  /// Of the later view in the earlier or the other way round.
  RelativePose between(std::size_t first, std::size_t second) const;

 private:
  std::vector<RelativePose> steps_;
  std::vector<RelativePose> from_start_;
};

}  // namespace plumbline
