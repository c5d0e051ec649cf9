// What becomes of tracking after an interruption: the place is recognised or the frame is lost, and a place that was
// recognised is on trial until other views of it have been seen (docs/method.md §9).
#pragma once

#include <optional>

#include "place/relocaliser.h"
#include "plumbline/consistency.h"
#include "plumbline/frame.h"
#include "plumbline/parameters.h"
#include "plumbline/pinhole.h"
#include "tracking/interruption.h"
#include "tracking/live_frame.h"
#include "tracking/tracker.h"

namespace plumbline {

class Recovery {
 public:
  /// `backend` must outlive it.
  Recovery(const Parameters& parameters, const Pinhole& camera, const Backend& backend, const OrientationSensor& sensor,
           RenderModel render);

  /// Whether nothing links the frame to the previous accepted one. To be told of every frame, once.
  bool is_interrupted(const Frame& frame, const TrackerState& tracker);

  /// The place of a frame after an interruption, on trial from now on, or why it is lost.
  TrackedFrame recognise(const TrackerInput& input, const Tracker& tracker);

  /// A frame that was tracked from the previous one, or was lost in that: provisional while its place is on trial.
  void observe(TrackedFrame* tracked);

  /// The status of an accepted frame, by what the model shows at its pose: provisional while its place is on trial,
  /// tracked once the place is confirmed, lost if it is contradicted.
  TrackingStatus judge(const TrackedFrame& tracked, const LiveFrame& live, const PredictedSurface& model);

  /// Takes the place back that is on trial: the tracker is where it was before. False if there is none.
  bool revoke(Tracker* tracker);
  /// Whether so much speaks against the place on trial that it is to be taken back.
  bool has_failed() const;

  /// A frame that was fused, at its accepted pose.
  void remember(const LiveFrame& live, const Frame& frame, const Tracker& tracker);

  /// What was remembered against the model as it is now.
  ModelConsistency check_consistency() const { return relocaliser_.check_consistency(); }

 private:
  struct Trial {
    TrackerState before;
    SE3 world_from_camera;  ///< where the place was recognised
    bool is_clear;          ///< whether little spoke for another place
    int frames = 0, failures = 0;
  };
  bool is_confirmed(const PlaceEvidence& evidence, const LiveFrame& live, const PredictedSurface& model) const;
  PlaceView view_of(const LiveFrame& live, const Frame& frame, const TrackerState& tracker) const;
  PlaceQuery query_of(const TrackerInput& input, const Tracker& tracker) const;

  double max_gap_;  ///< seconds; 0: a frame after a gap is tracked as any other
  const Backend* backend_;
  FrameIntervals intervals_;
  Relocaliser relocaliser_;
  std::optional<Trial> trial_;
  int attempts_ = 0;  ///< frames since the interruption
};

}  // namespace plumbline
