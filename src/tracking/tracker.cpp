#include "tracking/tracker.h"

#include <algorithm>
#include <utility>

#include "plumbline/angles.h"
#include "tracking/starts.h"

namespace plumbline {
namespace {

constexpr double kUsualInterval = 1.0 / 30;  // seconds, where stamps do not tell

// So many frames at the start are also registered without the sensor, to judge it: a second at 30 Hz.
constexpr int kProbation = 30;
// The first of these go by the images alone, where the readings explain no more.
constexpr int kImagesDecide = 16;
// A gyroscope errs by little beside what it measures, unlike a chip's heading: as a part of a turn's square.
constexpr double kGyroscopeDistrust = 0.1, kGyroscopeFloor = radians(1.5);

// What two registrations of one frame must differ by in their agreement.
constexpr double kClearlyBetter = 0.15, kAsGood = 0.02;

bool is_clearly_better(const TrackingResult& unaided, const TrackingResult& aided, double previous_agreement) {
  if (is_doubtful(unaided, previous_agreement)) return false;
  return aided.status == TrackingStatus::lost || agreement(unaided) > agreement(aided) + kClearlyBetter;
}

/// One that fell into a worse minimum than the sensor led to says nothing about the sensor.
bool is_witness(const TrackingResult& unaided, const TrackingResult& aided) {
  return unaided.status == TrackingStatus::tracked && agreement(unaided) > agreement(aided) - kAsGood;
}

TrackedFrame found_from(const SE3& seed, const TrackingResult& result, int starts) {
  TrackedFrame found;
  found.result = result;
  found.world_from_seed = seed;
  found.starts = starts;
  found.witness = result.world_from_camera.rotation();
  return found;
}

/// One in a thousand, if the sensor and the images err as they are expected to.
bool is_surprised(const MotionFilter& filter, const TrackingResult& found) {
  constexpr double kLimit = 16.3;  // χ² of three degrees of freedom
  return found.rank == 6 && filter.rotation_surprise(found.world_from_camera, found.pose_covariance) > kLimit;
}

}  // namespace

Tracker::Tracker(const Parameters& parameters, const SE3& world_from_camera, const Backend& backend,
                 const OrientationSensor& sensor)
    : tracking_(parameters.tracking),
      orientation_(parameters.orientation),
      motion_(parameters.motion),
      backend_(&backend),
      state_{.world_from_camera = world_from_camera,
             .motion = MotionModel(tracking_.speed_sigma, tracking_.speed_memory),
             .turn = {},
             .guide = OrientationGuide(orientation_, sensor),
             .steady = MotionFilter(motion_),
             .inertial = MotionFilter(motion_),
             .gyroscope = OrientationMonitor(std::min(orientation_.distrust, kGyroscopeDistrust), kGyroscopeFloor)} {}

TrackedFrame Tracker::track(const TrackerInput& input, std::vector<IcpIteration>* trace) const {
  // The first frame defines the world: it is where it is expected.
  TrackingResult expected_result;
  expected_result.world_from_camera = state_.world_from_camera;
  expected_result.reason = input.live.has_depth() ? LostReason::none : LostReason::no_depth;
  TrackedFrame found = found_from(state_.world_from_camera, expected_result, 1);
  if (!input.live.has_depth()) return found;

  if (uses_filter(input.frame)) return track_filtered(input, std::move(found), trace);
  const OrientationUse use = state_.guide.use(input.frame.earth_from_camera);
  if (!state_.is_initialised) {
    found.result.status = TrackingStatus::initialised;
  } else {
    const Prediction expected = predict(input.frame);
    const Task task = {input, expected};
    found = use == OrientationUse::used ? register_aided(task, trace) : register_unaided(task, trace);
    if (use == OrientationUse::used && state_.guide.is_judged() && is_doubted(found))
      return better_of(std::move(found), register_unaided(task, nullptr));
  }
  found.orientation = use;
  return found;
}

bool Tracker::has_readings(const Frame& frame) const { return motion_.gyroscope && !frame.inertial.empty(); }

/// Whether this frame is predicted by the filter.
bool Tracker::uses_filter(const Frame& frame) const {
  return has_readings(frame) || (motion_.steady && !frame.earth_from_camera);
}

MotionFilter Tracker::steady_at(const Frame& frame) const {
  MotionFilter filter = state_.steady;
  filter.propagate({}, frame.time);
  return filter;
}

MotionFilter Tracker::inertial_at(const Frame& frame) const {
  MotionFilter filter = state_.inertial;
  filter.propagate(frame.inertial, frame.time);
  return filter;
}

/// Around the registration: it starts from the filter's prediction, holds to it by its covariance, and corrects it.
TrackedFrame Tracker::track_filtered(const TrackerInput& input, TrackedFrame found,
                                     std::vector<IcpIteration>* trace) const {
  if (!state_.is_initialised) {
    found.result.status = TrackingStatus::initialised;
    found.orientation =
        has_readings(input.frame) ? OrientationUse::first : state_.guide.use(input.frame.earth_from_camera);
    return found;
  }
  if (has_readings(input.frame)) return register_inertial(inertial_at(input.frame), input, trace);
  found = register_filtered(steady_at(input.frame), input, trace);
  found.orientation = state_.guide.use(input.frame.earth_from_camera);
  return found;
}

TrackedFrame Tracker::register_filtered(const MotionFilter& filter, const TrackerInput& input,
                                        std::vector<IcpIteration>* trace) const {
  const Prediction expected = predict_filtered(filter, input.frame);
  TrackedFrame found = register_unaided({input, expected}, trace);
  if (found.result.rank == 6)
    found.least_known = least_known(found.result.world_from_camera.rotation(), found.result.pose_covariance,
                                    filter.pose_covariance(), expected.redundancy);
  return found;
}

/// From the readings, as long as the gyroscope turns as the images do; else as without them.
TrackedFrame Tracker::register_inertial(const MotionFilter& filter, const TrackerInput& input,
                                        std::vector<IcpIteration>* trace) const {
  const bool is_used = filter.is_inertial() && state_.gyroscope.trusted();
  TrackedFrame found = register_filtered(is_used ? filter : steady_at(input.frame), input, trace);
  found.orientation = is_used                ? OrientationUse::used
                      : filter.is_inertial() ? OrientationUse::distrusted
                                             : OrientationUse::missing;
  const bool surprised = is_used && is_surprised(filter, found.result);
  if (is_used && (surprised || is_doubted(found))) {
    const TrackedFrame steady = register_filtered(steady_at(input.frame), input, nullptr);
    const bool images_decide =
        (surprised || state_.probation < kImagesDecide) && is_witness(steady.result, found.result);
    found = better_of(std::move(found), steady);
    if (images_decide) found.result = steady.result;
    if (images_decide) found.least_known = steady.least_known;
  }
  found.inertial = filter;
  if (filter.is_inertial())
    found.turn = state_.inertial.world_from_camera().rotation().transpose() * filter.world_from_camera().rotation();
  return found;
}

Prediction Tracker::predict_filtered(const MotionFilter& filter, const Frame& frame) const {
  // A prediction that is little better than none outweighs no images, however alike they err.
  constexpr double kSteadyCorrelationTime = 0.2;  // seconds
  const double correlation_time =
      filter.is_inertial() ? motion_.correlation_time * state_.fit.repeated_share() : kSteadyCorrelationTime;
  Prediction expected;
  expected.world_from_camera = filter.world_from_camera();
  expected.terms.set(pose_prior(filter.world_from_camera(), filter.pose_covariance()));
  expected.redundancy = std::max(1.0, correlation_time / seconds_since_previous(frame));
  return expected;
}

/// The pose to start from, and the motion prior where the parameters have one.
Prediction Tracker::predict(const Frame& frame) const {
  const double seconds = seconds_since_previous(frame);
  const SE3& previous = state_.world_from_camera;
  Prediction expected;
  expected.world_from_camera = previous;
  if (tracking_.speed_memory > 0)
    expected.world_from_camera = {state_.turn.predict(previous.rotation(), seconds), previous.translation()};
  if (tracking_.speed_sigma > 0) {
    const PositionPrediction position = state_.motion.predict(previous.translation(), seconds);
    expected.terms.set(translation_prior(position.mean, position.covariance));
  }
  return expected;
}

/// After a large turn several starts are tried, for the sensor's heading may be far off.
TrackedFrame Tracker::register_aided(const Task& task, std::vector<IcpIteration>* trace) const {
  const Eigen::Matrix3d& earth_from_camera = *task.input.frame.earth_from_camera;
  const SE3 expected = state_.guide.seed(task.expected.world_from_camera, earth_from_camera);
  const std::vector<SE3> starts = state_.guide.starts(expected, earth_from_camera);
  const bool turned_far = starts.size() > 1;
  const SE3 seed = turned_far ? best_of(starts, task, true) : starts.front();
  const TrackingResult result = register_from(seed, task, true, turned_far ? patient(tracking_) : tracking_, trace);
  return retry_if_doubtful(found_from(seed, result, static_cast<int>(starts.size())), task, true, trace);
}

TrackedFrame Tracker::register_unaided(const Task& task, std::vector<IcpIteration>* trace) const {
  const SE3& seed = task.expected.world_from_camera;
  const TrackingResult result = register_from(seed, task, false, tracking_, trace);
  return retry_if_doubtful(found_from(seed, result, 1), task, false, trace);
}

/// Where images and model disagree, turns about the seed are tried, and the best is taken if it is beyond doubt.
TrackedFrame Tracker::retry_if_doubtful(TrackedFrame found, const Task& task, bool with_orientation,
                                        std::vector<IcpIteration>* trace) const {
  const double step = (with_orientation ? orientation_.search : tracking_.search).radians();
  if (step <= 0 || !is_doubtful(found.result, state_.previous_agreement)) return found;
  const std::vector<SE3> starts = turned_about(found.world_from_seed, step);
  found.starts += static_cast<int>(starts.size());
  const SE3 seed = best_of(starts, task, with_orientation);
  std::vector<IcpIteration> iterations;
  const TrackingResult result =
      register_from(seed, task, with_orientation, patient(tracking_), trace == nullptr ? nullptr : &iterations);
  if (is_doubtful(result, state_.previous_agreement)) return found;
  if (trace != nullptr) *trace = iterations;
  return found_from(seed, result, found.starts);
}

/// Whether the sensor is still to prove itself, or led nowhere.
bool Tracker::is_doubted(const TrackedFrame& found) const {
  return state_.probation < kProbation || found.result.status == TrackingStatus::lost;
}

/// A registration that owes the sensor nothing is its witness, and is taken where it alone leads anywhere or clearly
/// farther.
TrackedFrame Tracker::better_of(TrackedFrame aided, TrackedFrame unaided) const {
  unaided.was_compared = aided.was_compared = true;
  unaided.orientation = OrientationUse::dropped;
  aided.orientation = OrientationUse::used;
  if (is_clearly_better(unaided.result, aided.result, state_.previous_agreement)) return unaided;
  aided.witness.reset();
  if (is_witness(unaided.result, aided.result)) aided.witness = unaided.witness;
  return aided;
}

/// The start from which a coarse registration explains most.
SE3 Tracker::best_of(const std::vector<SE3>& starts, const Task& task, bool with_orientation) const {
  const TrackingParameters tracking = coarse(tracking_);
  std::vector<double> agreements;
  agreements.reserve(starts.size());
  for (const SE3& start : starts)
    agreements.push_back(agreement(register_from(start, task, with_orientation, tracking, nullptr)));
  return starts[static_cast<std::size_t>(std::max_element(agreements.begin(), agreements.end()) - agreements.begin())];
}

TrackingResult Tracker::register_from(const SE3& seed, const Task& task, bool with_orientation,
                                      const TrackingParameters& tracking, std::vector<IcpIteration>* trace) const {
  RegistrationInput input;
  input.world_from_model = task.input.model.world_from_camera;
  input.world_from_camera_seed = seed;
  input.trace = trace;
  input.terms = task.expected.terms;
  if (with_orientation) state_.guide.add_term(*task.input.frame.earth_from_camera, &input.terms);
  TrackingParameters beside_terms = tracking;
  beside_terms.redundancy *= task.expected.redundancy;
  return register_frame(*backend_, task.input.live.pyramid(), task.input.model.levels, input, beside_terms);
}

void Tracker::accept(const Frame& frame, const TrackedFrame& tracked) {
  const SE3 previous = state_.world_from_camera;
  const SE3& current = tracked.result.world_from_camera;
  if (!tracked.is_first()) {
    const double seconds = seconds_since_previous(frame);
    state_.motion.observe(previous.translation(), current.translation(),
                          tracked.result.pose_covariance.bottomRightCorner<3, 3>(), seconds);
    state_.turn.observe(previous.rotation(), current.rotation(), seconds);
    state_.previous_agreement = agreement(tracked.result);
    state_.fit.observe(tracked.result.rms, tracked.least_known, seconds);
  }
  correct_filters(frame, tracked);
  judge_gyroscope(tracked);
  state_.world_from_camera = current;
  state_.time = frame.time;
  state_.is_initialised = true;
  if (tracked.was_compared) ++state_.probation;
  state_.guide.observe(current, frame.earth_from_camera, tracked.witness);
}

void Tracker::correct_filters(const Frame& frame, const TrackedFrame& tracked) {
  if (!motion_.steady && !motion_.gyroscope) return;
  const SE3& current = tracked.result.world_from_camera;
  const Matrix6d& covariance = tracked.result.pose_covariance;
  if (tracked.is_first() || !state_.steady.is_started()) {
    state_.steady.start(current, frame.time, {});
    state_.inertial.start(current, frame.time, frame.inertial);
    return;
  }
  state_.steady = steady_at(frame);
  state_.steady.correct(current, covariance);
  if (tracked.inertial && state_.gyroscope.trusted()) {
    state_.inertial = *tracked.inertial;
    state_.inertial.correct(current, covariance);
  } else {
    state_.inertial.start(current, frame.time, frame.inertial);
  }
}

/// By the turns of the images, where they owe the gyroscope nothing or nothing speaks against it.
void Tracker::judge_gyroscope(const TrackedFrame& tracked) {
  if (!tracked.turn) return;
  state_.start_from_camera = (state_.start_from_camera * *tracked.turn).eval();
  if (tracked.is_acceptable() && tracked.witness) state_.gyroscope.observe(state_.start_from_camera, *tracked.witness);
}

void Tracker::resume(const Frame& frame, const TrackedFrame& recovered) {
  state_.motion = MotionModel(tracking_.speed_sigma, tracking_.speed_memory);
  state_.turn.forget();
  TrackedFrame first = recovered;
  first.result.status = TrackingStatus::initialised;
  accept(frame, first);
  state_.previous_agreement = agreement(recovered.result);
  state_.travelled = recovered.travelled;
}

void Tracker::reject(const TrackedFrame& tracked) {
  if (tracked.was_compared) ++state_.probation;
  if (tracked.result.reason != LostReason::no_depth) state_.turn.forget();
  if (tracked.inertial) state_.inertial = *tracked.inertial;
  judge_gyroscope(tracked);
}

double Tracker::seconds_since_previous(const Frame& frame) const {
  return frame.time > state_.time ? to_seconds(frame.time - state_.time) : kUsualInterval;
}

}  // namespace plumbline
