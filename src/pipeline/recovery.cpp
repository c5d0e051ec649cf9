#include "pipeline/recovery.h"

#include <algorithm>
#include <utility>

#include "plumbline/time.h"

namespace plumbline {
namespace {

// Of a trial. Without it a place that looks the same turned by half a turn was accepted; six frames later it had moved
// far enough to be seen through.
constexpr double kSeenFrom = 0.25;  // radians, as pose_distance has them: another view
constexpr int kMaxFrames = 30, kMaxFailures = 2;
// What might be another place is looked at from farther about, however long that takes, until a view is seen that would
// be recognised by itself: a camera that stands still learns nothing.
constexpr double kSeenFromFarther = 0.35;

// A search costs as much as ten frames: after the first frames every third is searched for.
constexpr int kEager = 15, kSeldom = 3;

// What looks the same stands elsewhere in most buildings: a camera that is carried does not get there in no time.
constexpr double kMaxSpeed = 2, kMargin = 1;  // metres a second, metres

constexpr double kExpectedFor = 1;  // seconds, in which a camera is likely to be near where it was

}  // namespace

Recovery::Recovery(const Parameters& parameters, const Pinhole& camera, const Backend& backend,
                   const OrientationSensor& sensor, RenderModel render)
    : max_gap_(parameters.tracking.relocalise_after),
      backend_(&backend),
      relocaliser_(parameters, camera, backend, std::move(render), sensor) {}

bool Recovery::is_interrupted(const Frame& frame, const TrackerState& tracker) {
  intervals_.observe(frame.time);
  return max_gap_ > 0 && tracker.is_initialised && intervals_.is_interrupted(tracker.time, frame.time, max_gap_);
}

TrackedFrame Recovery::recognise(const TrackerInput& input, const Tracker& tracker) {
  TrackedFrame found;
  found.is_after_interruption = true;
  found.result.world_from_camera = found.world_from_seed = tracker.world_from_camera();
  found.result.reason = input.live.has_depth() ? LostReason::unknown_place : LostReason::no_depth;
  ++attempts_;
  if (!input.live.has_depth() || (attempts_ > kEager && attempts_ % kSeldom != 0)) return found;

  const Relocaliser::Search search = relocaliser_.find(query_of(input, tracker));
  found.starts = search.starts;
  if (!search.place) return found;
  found.result = search.place->evidence.result;
  found.result.status = TrackingStatus::provisional;
  found.result.reason = LostReason::none;
  found.world_from_seed = search.place->seed.world_from_camera;
  found.travelled = search.place->seed.travelled;
  found.is_recovered = true;
  trial_ = Trial{tracker.state(), found.result.world_from_camera, search.place->is_clear()};
  attempts_ = 0;
  return found;
}

PlaceView Recovery::view_of(const LiveFrame& live, const Frame& frame, const TrackerState& tracker) const {
  const OrientationUse use = tracker.guide.use(frame.earth_from_camera);
  const bool is_trusted = use == OrientationUse::used || use == OrientationUse::first;
  return {live.pyramid(), is_trusted ? frame.earth_from_camera : std::nullopt};
}

/// Where the tracker would go on is tried too: the tests decide, and a short gap costs nothing where they are passed.
PlaceQuery Recovery::query_of(const TrackerInput& input, const Tracker& tracker) const {
  PlaceQuery query{view_of(input.live, input.frame, tracker.state()), {tracker.viewpoint()}, {}};
  if (query.view.earth_from_camera && tracker.state().guide.use(input.frame.earth_from_camera) == OrientationUse::used)
    tracker.state().guide.add_term(*query.view.earth_from_camera, &query.terms);
  const double seconds = to_seconds(input.frame.time - tracker.state().time);
  query.previous = tracker.viewpoint();
  query.reach = kMargin + kMaxSpeed * std::max(seconds, 0.0);
  if (seconds < kExpectedFor) {
    query.is_near = true;
    const TrackedFrame tracked = tracker.track(input);
    if (tracked.is_acceptable()) query.expected.front().world_from_camera = tracked.result.world_from_camera;
  }
  return query;
}

void Recovery::observe(TrackedFrame* tracked) {
  attempts_ = 0;
  if (!trial_) return;
  if (tracked->is_acceptable())
    tracked->result.status = TrackingStatus::provisional;
  else
    ++trial_->failures;
}

TrackingStatus Recovery::judge(const TrackedFrame& tracked, const LiveFrame& live, const PredictedSurface& model) {
  if (!trial_ || tracked.is_recovered) return tracked.result.status;
  const DepthLevel& frame = live.pyramid()[live.pyramid().size() - model.levels.size()];
  const PlaceEvidence evidence{tracked.result, backend_->reduce(kernels::CompareDepth{
                                                   read_only(frame.depth), read_only(model.levels.front().depth)})};
  ++trial_->frames;
  trial_->failures += !evidence.meets(kOnTrial);
  if (has_failed()) return TrackingStatus::lost;
  if (!is_confirmed(evidence, live, model)) return TrackingStatus::provisional;
  trial_.reset();
  return TrackingStatus::tracked;
}

bool Recovery::is_confirmed(const PlaceEvidence& evidence, const LiveFrame& live, const PredictedSurface& model) const {
  const double moved = pose_distance(trial_->world_from_camera, evidence.result.world_from_camera);
  if (trial_->is_clear) return moved >= kSeenFrom || trial_->frames >= kMaxFrames;
  if (moved < kSeenFromFarther || !evidence.meets(kExpected)) return false;
  return relocaliser_.compare_details(live.pyramid(), model.levels).support() >= kDetailRecognised;
}

bool Recovery::has_failed() const { return trial_ && trial_->failures >= kMaxFailures; }

bool Recovery::revoke(Tracker* tracker) {
  if (!trial_) return false;
  tracker->set_state(trial_->before);
  trial_.reset();
  return true;
}

void Recovery::remember(const LiveFrame& live, const Frame& frame, const Tracker& tracker) {
  if (max_gap_ > 0) relocaliser_.remember(view_of(live, frame, tracker.state()), tracker.viewpoint());
}

}  // namespace plumbline
