// What two views say of the motion between them: one registered to the other, both ways.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "backend/maps.h"
#include "graph/view_comparison.h"
#include "graph/views.h"
#include "plumbline/parameters.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"

namespace plumbline {

/// A motion and how well it is known: of (θ, t), increments of its rotation from the left and of its translation, in
/// the first camera's axes; radians and metres.
struct RelativePose {
  SE3 first_from_second;
  Matrix6d covariance;
};

/// A registration of two views.
struct ViewEdge {
  std::size_t first = 0, second = 0;  ///< of the views
  RelativePose motion;                ///< halfway between both registrations; their difference is in the covariance
  Vector6d apart;                     ///< forward from backward: radians and metres
  double inconsistency = 0;           ///< the same in units of the covariances: χ² over 6
  ViewOverlap forward, backward;      ///< second's pixels in the first view, and the other way
  double overlap() const { return std::min(forward.overlap(), backward.overlap()); }
  double violation() const { return std::max(forward.violation(), backward.violation()); }
  double agreement() const { return std::min(forward.agreement(), backward.agreement()); }
};

/// The inverse motion with its covariance.
RelativePose inverse(const RelativePose& motion);

/// rᵀ Σ⁻¹ r / 6 of the difference of two motions between the same views, Σ the sum of their covariances.
double normalised_difference(const SE3& a, const SE3& b, const Matrix6d& covariance);

/// Where a registration of two views begins.
enum class Reach {
  near,  ///< where they are, as frames are tracked
  far    ///< the same after a coarse registration with wide gates
};

/// Registers views to views. Keeps the maps of those that it met of late; results do not depend on which these are.
class ViewMatcher {
 public:
  /// `backend` must outlive it. `camera`: of the recording's frames.
  ViewMatcher(const Parameters& parameters, const Pinhole& camera, const Backend& backend);

  /// From where `views` has them. Nothing if either way does not hold all six directions.
  std::optional<ViewEdge> match(const std::vector<PathView>& views, std::size_t first, std::size_t second, Reach reach);

 private:
  struct Loaded {
    DepthPyramid levels;
    std::optional<std::size_t> view;
    std::size_t used = 0;  ///< when, in calls
  };
  const DepthPyramid& load(const std::vector<PathView>& views, std::size_t view);
  std::optional<RelativePose> align(const DepthPyramid& live, const DepthPyramid& model, const SE3& model_from_live,
                                    Reach reach) const;

  TrackingParameters far_, near_;
  Pinhole level_camera_;
  const Backend* backend_;
  std::vector<Loaded> loaded_;
  std::size_t calls_ = 0;
};

}  // namespace plumbline
