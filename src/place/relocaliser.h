// Where a camera is that has been lost: which of the places that were mapped a frame shows, or none (docs/method.md
// §9).
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "backend/maps.h"
#include "core/viewpoint.h"
#include "kernels/terms.h"
#include "place/detail.h"
#include "place/keyframes.h"
#include "plumbline/consistency.h"
#include "plumbline/orientation.h"
#include "plumbline/parameters.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "tracking/registration.h"
#include "tracking/tracker.h"

namespace plumbline {

/// Writes what a camera sees of the model into a pyramid's depth and normals.
using RenderModel = std::function<void(const Viewpoint& from, DepthPyramid* levels)>;

/// What a frame must show to be where it is said to be.
struct PlaceLimits {
  double agreement, see_through, matched, known;
  double uncertainty = std::numeric_limits<double>::infinity();  ///< metres
};
/// Of a frame that was lost, and of one whose place is on trial. A view along a corridor or of a bare wall fits many
/// places: a frame must hold its position to a seventh of the 5 cm beyond which a place is a wrong one.
constexpr PlaceLimits kRecognised = {0.4, 0.04, 0.88, 0.4, 0.007}, kOnTrial = {0.25, 0.06, 0.8, 0};
/// Of a frame that leaves its position more open, but sees through next to nothing, as wrong places do.
constexpr PlaceLimits kOpen = {0.4, 0.01, 0.88, 0.4, 0.015};
/// Of a frame that leaves little doubt, as most do that are recognised rightly.
constexpr PlaceLimits kClear = {0.4, 0.025, 0.94, 0.4, 0.005};
/// Of a frame that follows the one before it after a short gap, near where it was expected.
constexpr PlaceLimits kExpected = {0.4, 0.04, 0.88, 0.4, 0.015};

/// What there must be besides large planes, as `DetailComparison::support` has it: of a frame that was lost, and of one
/// that leaves little doubt. Wrong places that passed all other tests had 0.06 at most, right ones 0.09 and more
/// (docs/results.md).
constexpr double kDetailRecognised = 0.075, kDetailClear = 0.1;

/// A pose, and what the frame and the model rendered there have in common.
struct PlaceEvidence {
  TrackingResult result;
  DepthComparison depth;
  DetailComparison detail = {};  ///< only where all else is met

  double agreement() const;    ///< of the registration
  double uncertainty() const;  ///< of the camera's position, in the direction that is held least; metres
  bool meets(const PlaceLimits& limits) const;
};

/// What there is to find a frame's place by.
struct PlaceQuery {
  PlaceView view;
  std::vector<Viewpoint> expected;                         ///< that are tried whatever the frame looks like
  kernels::Terms terms;                                    ///< what is known of the pose besides
  Viewpoint previous = {};                                 ///< where the camera was seen before
  double reach = std::numeric_limits<double>::infinity();  ///< metres that it can have gone since
  bool is_near = false;                                    ///< whether it is likely to be near what is expected
};

struct FoundPlace {
  PlaceEvidence evidence;
  Viewpoint seed;            ///< where its final registration started
  double rival = 0;          ///< agreement of the best other place
  int starts = 0;            ///< poses that were tried
  bool is_expected = false;  ///< whether it is where the camera would be had it gone on

  /// Whether little speaks for another place, known or not.
  bool is_clear() const;
};

class Relocaliser {
 public:
  /// `backend` must outlive it.
  Relocaliser(const Parameters& parameters, const Pinhole& camera, const Backend& backend, RenderModel render,
              const OrientationSensor& sensor = {});

  /// A frame that was tracked and fused: a keyframe, if none is near.
  void remember(const PlaceView& view, const Viewpoint& from) { keyframes_.offer(view, from); }

  /// The place that the frame shows: none unless it passes all tests and no other place explains the frame nearly as
  /// well. Without `place` what comes of it is how many starts were tried.
  struct Search {
    std::optional<FoundPlace> place;
    int starts = 0;
  };
  Search find(const PlaceQuery& query) const;

  /// A live pyramid beside the model rendered at the pose of its registration.
  /// `travelled`: of the part of the map that it was registered to.
  PlaceEvidence look(const DepthPyramid& live, const TrackingResult& result, double travelled) const;

  /// What both show besides planes.
  /// `model`: at the pose that is compared; its finest level is one of `live`.
  DetailComparison compare_details(const DepthPyramid& live, const DepthPyramid& model) const;

  /// The keyframes beside the model rendered at their poses.
  ModelConsistency check_consistency() const;

  const Keyframes& keyframes() const { return keyframes_; }

 private:
  struct Candidate {
    Viewpoint from;
    double agreement;
  };
  template <class IsPossible>
  std::vector<Candidate> from_keyframes(const PlaceQuery& query, const IsPossible& is_possible, int* starts) const;
  std::vector<SE3> starts_at(const Keyframe& keyframe, const PlaceQuery& query) const;
  bool is_recognised(FoundPlace* place, const PlaceQuery& query) const;
  bool is_in_sight(const Keyframe& keyframe, const PlaceQuery& query) const;
  void load(const Keyframe& keyframe) const;
  std::vector<Viewpoint> distinct_starts(const PlaceQuery& query, int* starts) const;
  std::vector<FoundPlace> look_alikes(const FoundPlace& place, const PlaceQuery& query, int* starts) const;
  FoundPlace refine(const Viewpoint& start, const PlaceQuery& query) const;

  TrackingParameters tracking_, coarse_;
  bool has_heading_;
  const Backend* backend_;
  RenderModel render_;
  Keyframes keyframes_;
  mutable DepthPyramid keyframe_levels_;  ///< of the keyframe that is registered to; scratch
  mutable DepthPyramid model_levels_;     ///< of the pose that is looked at; scratch
};

}  // namespace plumbline
