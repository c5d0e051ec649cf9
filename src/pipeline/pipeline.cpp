#include "plumbline/pipeline.h"
#include "plumbline/mesh.h"

#include <chrono>

#include "backend/backend.h"
#include "map/changed_bricks.h"
#include "map/volume.h"
#include "pipeline/recovery.h"
#include "plumbline/config.h"
#include "plumbline/frame.h"
#include "plumbline/image.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "tracking/live_frame.h"
#include "tracking/tracker.h"

namespace plumbline {
namespace {

/// Runs a stage, adds its wall time in milliseconds and returns what it returns.
template <class Stage>
auto timed(double* milliseconds, const Stage& stage) {
  struct Stopwatch {
    double* milliseconds;
    std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
    ~Stopwatch() {
      *milliseconds += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    }
  } const stopwatch{milliseconds};
  return stage();
}

std::vector<IcpIteration>* iterations_of(FrameDiagnostics* diagnostics) {
  return diagnostics != nullptr && diagnostics->want_iterations ? &diagnostics->iterations : nullptr;
}

double angle_between(const SE3& a, const SE3& b) { return so3::angle(a.rotation().transpose() * b.rotation()); }

const Parameters& validated(const Parameters& parameters) {
  validate(parameters);
  return parameters;
}

}  // namespace

struct Pipeline::State {
  State(const Parameters& p, const Pinhole& k, Backend& b, const SE3& initial_pose, bool with_color,
        const OrientationSensor& sensor)
      : parameters(validated(p)),
        camera(k),
        backend(b),
        live(k, p.preprocess, pyramid_levels(p.tracking), b, with_color, p.tracking.finest_level),
        tracker(p, initial_pose, b, sensor),
        volume(p.volume, k, b, with_color),
        model{make_pyramid(k, static_cast<int>(p.tracking.iterations.size()), b, p.tracking.finest_level), SE3()},
        recovery(p, k, b, sensor, [this](const Viewpoint& from, DepthPyramid* levels) {
          volume.visit(from);
          render(from.world_from_camera, levels);
        }) {}

  TrackedFrame locate(const Frame& frame, std::vector<IcpIteration>* trace);
  void accept(const Frame& frame, const TrackedFrame& tracked);
  void fuse(const SE3& world_from_camera);
  void follow(const SE3& world_from_camera);
  void come_back();
  void render(const SE3& world_from_camera, DepthPyramid* levels);
  void predict(const SE3& world_from_camera);
  void take_back(FrameReport* report);
  void report_pose(const TrackedFrame& tracked, FrameReport* report) const;
  void place_volume_at(const SE3& world_from_camera);
  void explain(const TrackingResult& result, FrameDiagnostics* diagnostics) const;

  Parameters parameters;
  Pinhole camera;
  Backend& backend;
  LiveFrame live;
  Tracker tracker;
  Volume volume;
  PredictedSurface model;
  Recovery recovery;
  std::optional<ChangedBricks> changes;  ///< none before somebody wants them
};

Pipeline::Pipeline(const Parameters& parameters, const Pinhole& camera, Backend& backend, const SE3& initial_pose,
                   bool with_color, const OrientationSensor& sensor)
    : state_(std::make_unique<State>(parameters, camera, backend, initial_pose, with_color && parameters.volume.color,
                                     sensor)) {}
Pipeline::~Pipeline() = default;

FrameReport Pipeline::process(const Frame& frame, FrameDiagnostics* diagnostics) {
  State& s = *state_;
  FrameReport report;
  report.index = frame.index;
  report.time = frame.time;

  // 1. Surface measurement: metres, smoothing, pyramid, normals.
  timed(&report.milliseconds.preprocess, [&] { s.live.prepare(frame); });

  // 2. Pose estimation against the model as the previous accepted frame sees it; the first frame defines the world.
  const TrackedFrame tracked =
      timed(&report.milliseconds.track, [&] { return s.locate(frame, iterations_of(diagnostics)); });
  s.report_pose(tracked, &report);
  if (!tracked.is_recovered) s.explain(tracked.result, diagnostics);
  if (!tracked.is_acceptable()) {
    s.tracker.reject(tracked);
    if (s.recovery.has_failed()) s.take_back(&report);
    return report;  // not fused, and the model is kept
  }
  s.accept(frame, tracked);
  const SE3& world_from_camera = report.world_from_camera = s.tracker.world_from_camera();

  // 3. Fusion of the raw depth, and of colour where there is some; not at a place that is on trial.
  if (has_pose(tracked.result.status)) timed(&report.milliseconds.integrate, [&] { s.fuse(world_from_camera); });

  // 4. Surface prediction for the next frame.
  timed(&report.milliseconds.raycast, [&] { s.predict(world_from_camera); });
  report.tracking.status = s.recovery.judge(tracked, s.live, s.model);
  if (report.tracking.status == TrackingStatus::lost) s.take_back(&report);
  return report;
}

/// Tracked from the previous accepted frame, or, after an interruption, recognised.
TrackedFrame Pipeline::State::locate(const Frame& frame, std::vector<IcpIteration>* trace) {
  if (recovery.is_interrupted(frame, tracker.state())) {
    if (recovery.revoke(&tracker)) predict(tracker.world_from_camera());
    return recovery.recognise({frame, live, model}, tracker);
  }
  TrackedFrame tracked = tracker.track({frame, live, model}, trace);
  recovery.observe(&tracked);
  return tracked;
}

void Pipeline::State::accept(const Frame& frame, const TrackedFrame& tracked) {
  if (tracked.is_first()) place_volume_at(tracked.result.world_from_camera);
  if (tracked.is_recovered)
    tracker.resume(frame, tracked);
  else
    tracker.accept(frame, tracked);
  if (has_pose(tracked.result.status)) recovery.remember(live, frame, tracker);
}

void Pipeline::State::fuse(const SE3& world_from_camera) {
  follow(world_from_camera);
  volume.integrate(live.raw_depth(), live.color(), camera, world_from_camera);
  if (changes) changes->note(volume.updated_bricks());
}

/// The map's window is where the tracker's camera is.
void Pipeline::State::follow(const SE3& world_from_camera) {
  tracker.set_travelled(volume.follow({world_from_camera, tracker.state().travelled}));
}

/// To the map as the tracker's camera left it, from the places that were looked at.
void Pipeline::State::come_back() {
  if (tracker.state().is_initialised) follow(tracker.world_from_camera());
}

void Pipeline::State::render(const SE3& world_from_camera, DepthPyramid* levels) {
  volume.predict(world_from_camera, raycast_range(parameters.preprocess.max_depth), levels);
}

void Pipeline::State::predict(const SE3& world_from_camera) {
  follow(world_from_camera);
  render(world_from_camera, &model.levels);
  model.world_from_camera = world_from_camera;
}

/// The place on trial was a wrong one: all is as it was before it was recognised.
void Pipeline::State::take_back(FrameReport* report) {
  recovery.revoke(&tracker);
  predict(tracker.world_from_camera());
  report->tracking.status = TrackingStatus::lost;
  report->tracking.reason = LostReason::unconfirmed;
  report->world_from_camera = tracker.world_from_camera();
}

/// Before the frame is accepted: angles are those from the previous accepted pose.
void Pipeline::State::report_pose(const TrackedFrame& tracked, FrameReport* report) const {
  report->tracking = tracked.result;
  report->orientation = tracked.orientation;
  report->starts = tracked.starts;
  report->sensor_lateness = tracker.state().inertial.lateness();
  report->is_after_interruption = tracked.is_after_interruption;
  report->is_recovered = tracked.is_recovered;
  report->world_from_camera = tracker.world_from_camera();
  if (tracked.result.iterations.empty()) return;  // not registered
  report->seed_angle = angle_between(tracker.world_from_camera(), tracked.world_from_seed);
  report->seed_to_result_angle = angle_between(tracked.world_from_seed, tracked.result.world_from_camera);
}

void Pipeline::State::place_volume_at(const SE3& world_from_camera) {
  volume.place(place_volume(parameters.volume, camera, world_from_camera, download(backend, live.raw_depth())));
}

void Pipeline::State::explain(const TrackingResult& result, FrameDiagnostics* diagnostics) const {
  if (diagnostics == nullptr || !diagnostics->want_pixel_use || result.iterations.empty()) return;
  diagnostics->pixel_use =
      explain_pixels(backend, live.pyramid(), model.levels, model.world_from_camera, result, parameters.tracking);
}

Mesh Pipeline::extract_mesh() const {
  state_->come_back();
  return state_->volume.extract_mesh(state_->parameters.mesh);
}

ModelConsistency Pipeline::check_consistency() const { return state_->recovery.check_consistency(); }

Map Pipeline::extract_map() const {
  state_->come_back();
  return state_->volume.extract_map();
}

MapUpdate Pipeline::take_changes(int max_bricks) {
  State& s = *state_;
  if (!s.changes) s.changes.emplace(s.volume.bricks_with_surface());
  MapUpdate update = s.volume.copy_bricks(s.changes->take(max_bricks));
  update.waiting = s.changes->waiting();
  return update;
}

SE3 Pipeline::world_from_camera() const { return state_->tracker.world_from_camera(); }
SE3 Pipeline::world_from_volume() const { return state_->volume.world_from_volume(); }
double Pipeline::volume_side() const { return state_->volume.side(); }

}  // namespace plumbline
