#include "plumbline/pipeline.h"
#include "plumbline/mesh.h"

#include <algorithm>
#include <chrono>
#include <numbers>
#include <utility>

#include "backend/backend.h"
#include "map/volume.h"
#include "plumbline/config.h"
#include "plumbline/frame.h"
#include "plumbline/image.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "tracking/live_frame.h"
#include "tracking/motion_model.h"
#include "tracking/orientation_guide.h"
#include "tracking/start_search.h"
#include "tracking/tracker.h"

namespace plumbline {
namespace {

/// Runs a stage and adds its wall time, milliseconds.
template <class Stage>
void timed(double* milliseconds, const Stage& stage) {
  const auto start = std::chrono::steady_clock::now();
  stage();
  *milliseconds += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

constexpr double kUsualInterval = 1.0 / 30;  // seconds, where stamps do not tell

double angle_between(const SE3& a, const SE3& b) { return so3::angle(a.rotation().transpose() * b.rotation()); }

// What two registrations of one frame must differ by in their agreement.
constexpr double kClearlyBetter = 0.15, kAsGood = 0.02;

bool is_clearly_better(const TrackingResult& unaided, const TrackingResult& aided, double last_agreement) {
  if (is_doubtful(unaided, last_agreement)) return false;
  return aided.status == TrackingStatus::lost || agreement(unaided) > agreement(aided) + kClearlyBetter;
}

/// One that fell into a worse minimum than the sensor led to says nothing about the sensor.
bool is_witness(const TrackingResult& unaided, const TrackingResult& aided) {
  return unaided.status == TrackingStatus::tracked && agreement(unaided) > agreement(aided) - kAsGood;
}

/// A frame's registration, where it started, and how many starts were tried.
struct Registration {
  TrackingResult result;
  SE3 seed;
  int starts = 1;
};

const Parameters& validated(const Parameters& parameters) {
  validate(parameters);
  return parameters;
}

}  // namespace

struct Pipeline::State {
  State(const Parameters& p, const Pinhole& k, Backend& b, const SE3& initial_pose, bool with_color)
      : parameters(validated(p)),
        camera(k),
        backend(b),
        live(k, p.preprocess, pyramid_levels(p.tracking), b, with_color, p.tracking.finest_level),
        model(make_pyramid(k, static_cast<int>(p.tracking.iterations.size()), b, p.tracking.finest_level)),
        volume(p.volume, k, b, with_color),
        guide(p.orientation),
        motion(p.tracking.speed_sigma, p.tracking.speed_memory),
        world_from_camera(initial_pose) {}

  TrackingResult initialise();
  TrackingResult register_frame(const Frame& frame, FrameReport* report, FrameDiagnostics* diagnostics);
  TrackingResult register_from(const SE3& seed, const Frame& frame, bool with_orientation,
                               const TrackingParameters& tracking, std::vector<IcpIteration>* trace) const;
  Registration register_aided(const Frame& frame, std::vector<IcpIteration>* trace) const;
  Registration register_unaided(const Frame& frame, std::vector<IcpIteration>* trace) const;
  Registration mended(Registration found, const Frame& frame, bool with_orientation,
                      std::vector<IcpIteration>* trace) const;
  SE3 best_of(const std::vector<SE3>& starts, const Frame& frame, bool with_orientation) const;
  SE3 expected_pose(const Frame& frame) const;
  void believe(const Frame& frame, const TrackingResult& tracking, const std::optional<TrackingResult>& witness);
  Image<std::uint8_t> explain(const TrackingResult& tracking) const;
  double seconds_since_last(const Frame& frame) const {
    return frame.time > time ? to_seconds(frame.time - time) : kUsualInterval;
  }

  Parameters parameters;
  Pinhole camera;
  Backend& backend;
  LiveFrame live;
  DepthPyramid model;  ///< what `world_from_model` sees of the volume
  Volume volume;
  OrientationGuide guide;
  MotionModel motion;
  SteadyTurn turn;
  SE3 world_from_camera;      ///< the last pose that was believed
  Nanoseconds time = 0;       ///< and its frame's
  double last_agreement = 1;  ///< of the last frame that was believed
  SE3 world_from_model;
  int probation = 0;  ///< frames that were also registered without the sensor
  bool initialised = false;
};

Pipeline::Pipeline(const Parameters& parameters, const Pinhole& camera, Backend& backend, const SE3& initial_pose,
                   bool with_color)
    : state_(
          std::make_unique<State>(parameters, camera, backend, initial_pose, with_color && parameters.volume.color)) {}
Pipeline::~Pipeline() = default;

FrameReport Pipeline::process(const Frame& frame, FrameDiagnostics* diagnostics) {
  State& s = *state_;
  FrameReport report;
  report.index = frame.index;
  report.time = frame.time;

  // 1. Surface measurement: metres, smoothing, pyramid, normals.
  timed(&report.milliseconds.preprocess, [&] { s.live.prepare(frame); });

  // 2. Sensor pose estimation against the prediction from the last pose; the first frame defines the world.
  timed(&report.milliseconds.track,
        [&] { report.tracking = s.initialised ? s.register_frame(frame, &report, diagnostics) : s.initialise(); });
  report.world_from_camera = s.world_from_camera;
  if (diagnostics != nullptr && diagnostics->want_pixel_use && !report.tracking.iterations.empty())
    diagnostics->pixel_use = s.explain(report.tracking);
  if (report.tracking.status == TrackingStatus::lost) return report;  // not fused, and the model is kept
  if (report.tracking.status == TrackingStatus::initialised) {
    report.orientation = s.guide.use(frame.earth_from_camera);
    s.believe(frame, report.tracking, report.tracking);
  }
  report.world_from_camera = s.world_from_camera;

  // 3. Fusion of the raw depth, and of colour where there is some.
  timed(&report.milliseconds.integrate,
        [&] { s.volume.integrate(s.live.raw_depth(), s.live.color(), s.camera, s.world_from_camera); });

  // 4. Surface prediction for the next frame.
  timed(&report.milliseconds.raycast, [&] { s.volume.predict(s.world_from_camera, s.parameters.raycast, &s.model); });
  s.world_from_model = s.world_from_camera;
  return report;
}

TrackingResult Pipeline::State::initialise() {
  TrackingResult result;
  result.world_from_camera = world_from_camera;
  if (!live.has_depth()) {
    result.reason = LostReason::no_depth;
    return result;
  }
  volume.place(place_volume(parameters.volume, camera, world_from_camera, download(backend, live.raw_depth())));
  initialised = true;
  result.status = TrackingStatus::initialised;
  return result;
}

/// With the sensor where it is believed. Without it in its place if only that way leads anywhere; and, at the start,
/// beside it, as a witness that owes the sensor nothing.
TrackingResult Pipeline::State::register_frame(const Frame& frame, FrameReport* report, FrameDiagnostics* diagnostics) {
  TrackingResult nothing;
  nothing.world_from_camera = world_from_camera;
  nothing.reason = LostReason::no_depth;
  if (!live.has_depth()) return nothing;

  report->orientation = guide.use(frame.earth_from_camera);
  const bool aided = report->orientation == OrientationUse::used;
  std::vector<IcpIteration>* trace =
      diagnostics != nullptr && diagnostics->want_iterations ? &diagnostics->iterations : nullptr;
  Registration found = aided ? register_aided(frame, trace) : register_unaided(frame, trace);

  std::optional<TrackingResult> witness = found.result;
  const bool doubted = probation < parameters.orientation.probation || found.result.status == TrackingStatus::lost;
  if (aided && guide.is_judged() && doubted) {
    ++probation;
    const Registration unaided = register_unaided(frame, nullptr);
    witness = unaided.result;
    if (is_clearly_better(unaided.result, found.result, last_agreement)) {
      found = unaided;
      report->orientation = OrientationUse::dropped;
    } else if (!is_witness(unaided.result, found.result)) {
      witness.reset();
    }
  }
  report->starts = found.starts;
  report->seed_angle = angle_between(world_from_camera, found.seed);
  report->seed_to_result_angle = angle_between(found.seed, found.result.world_from_camera);
  if (found.result.status == TrackingStatus::tracked)
    believe(frame, found.result, witness);
  else
    turn.forget();
  return found.result;
}

/// After a large turn several starts are tried, for the sensor's heading may be far off.
Registration Pipeline::State::register_aided(const Frame& frame, std::vector<IcpIteration>* trace) const {
  const Eigen::Matrix3d& earth_from_camera = *frame.earth_from_camera;
  const std::vector<SE3> starts = guide.starts(guide.seed(expected_pose(frame), earth_from_camera), earth_from_camera);
  const bool turned_far = starts.size() > 1;
  const SE3 seed = turned_far ? best_of(starts, frame, true) : starts.front();
  const TrackingParameters tracking = turned_far ? patient(parameters.tracking) : parameters.tracking;
  return mended({register_from(seed, frame, true, tracking, trace), seed, static_cast<int>(starts.size())}, frame, true,
                trace);
}

Registration Pipeline::State::register_unaided(const Frame& frame, std::vector<IcpIteration>* trace) const {
  const SE3 seed = expected_pose(frame);
  return mended({register_from(seed, frame, false, parameters.tracking, trace), seed}, frame, false, trace);
}

/// Where images and model disagree, turns about the seed are tried, and the best is believed if it is beyond doubt.
Registration Pipeline::State::mended(Registration found, const Frame& frame, bool with_orientation,
                                     std::vector<IcpIteration>* trace) const {
  const double step = with_orientation ? parameters.orientation.search : parameters.tracking.search;
  if (step <= 0 || !is_doubtful(found.result, last_agreement)) return found;
  const std::vector<SE3> starts = turned_about(found.seed, step * std::numbers::pi / 180);
  found.starts += static_cast<int>(starts.size());
  const SE3 other = best_of(starts, frame, with_orientation);
  std::vector<IcpIteration> iterations;
  const TrackingResult searched = register_from(other, frame, with_orientation, patient(parameters.tracking),
                                                trace == nullptr ? nullptr : &iterations);
  if (is_doubtful(searched, last_agreement)) return found;
  if (trace != nullptr) *trace = iterations;
  return {searched, other, found.starts};
}

/// The start from which a coarse registration explains most.
SE3 Pipeline::State::best_of(const std::vector<SE3>& starts, const Frame& frame, bool with_orientation) const {
  const TrackingParameters tracking = coarse(parameters.tracking);
  std::vector<double> agreements;
  agreements.reserve(starts.size());
  for (const SE3& start : starts)
    agreements.push_back(agreement(register_from(start, frame, with_orientation, tracking, nullptr)));
  return starts[static_cast<std::size_t>(std::max_element(agreements.begin(), agreements.end()) - agreements.begin())];
}

TrackingResult Pipeline::State::register_from(const SE3& seed, const Frame& frame, bool with_orientation,
                                              const TrackingParameters& tracking,
                                              std::vector<IcpIteration>* trace) const {
  TrackingInput input;
  input.world_from_model = world_from_model;
  input.world_from_camera_seed = seed;
  input.trace = trace;
  if (with_orientation) input.priors = guide.priors(*frame.earth_from_camera);
  if (parameters.tracking.speed_sigma > 0) {
    const PositionBelief expected = motion.predict(world_from_camera.translation(), seconds_since_last(frame));
    input.priors.has_position = true;
    input.priors.position = translation_prior(expected.mean, expected.covariance);
  }
  return track(backend, live.pyramid(), model, input, tracking);
}

/// What to start from without a sensor.
SE3 Pipeline::State::expected_pose(const Frame& frame) const {
  if (!parameters.tracking.steady_turn) return world_from_camera;
  return {turn.predict(world_from_camera.rotation(), seconds_since_last(frame)), world_from_camera.translation()};
}

/// `witness`: the registration whose rotation the sensor is judged by, if there is one.
void Pipeline::State::believe(const Frame& frame, const TrackingResult& tracking,
                              const std::optional<TrackingResult>& witness) {
  if (tracking.status == TrackingStatus::tracked) {
    const double seconds = seconds_since_last(frame);
    motion.observe(world_from_camera.translation(), tracking.world_from_camera.translation(),
                   tracking.position_covariance, seconds);
    turn.observe(world_from_camera.rotation(), tracking.world_from_camera.rotation(), seconds);
    last_agreement = agreement(tracking);
  }
  world_from_camera = tracking.world_from_camera;
  time = frame.time;
  std::optional<Eigen::Matrix3d> rotation;
  if (witness) rotation = witness->world_from_camera.rotation();
  guide.observe(world_from_camera, frame.earth_from_camera, rotation);
}

Image<std::uint8_t> Pipeline::State::explain(const TrackingResult& tracking) const {
  const DepthLevel& live_level = live.pyramid()[static_cast<std::size_t>(parameters.tracking.finest_level)];
  const Plane<std::uint8_t> use(live_level.camera.width, live_level.camera.height, backend);
  kernels::IcpInput in = icp_input(live_level, model.front());
  const kernels::RegistrationRules rules = registration_rules(parameters.tracking);
  rules.set_gates(world_from_model.inverse() * tracking.world_from_camera, tracking.median_distance, &in);
  if (rules.median_filter) rules.set_band(tracking.median_distance, &in);
  backend.run(kernels::ExplainPixels{in, use.view()});
  return download(backend, use);
}

Mesh Pipeline::extract_mesh() const { return state_->volume.extract_mesh(state_->parameters.mesh); }

SE3 Pipeline::world_from_volume() const { return state_->volume.world_from_volume(); }
double Pipeline::volume_side() const { return state_->volume.side(); }

}  // namespace plumbline
