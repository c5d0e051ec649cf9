#include "pipeline/pipeline.h"

#include <chrono>

#include "core/config.h"
#include "mapping/volume.h"
#include "tracking/live_frame.h"

namespace plumbline {
namespace {

/// Runs a stage and adds its wall time, milliseconds.
template <class Stage>
void timed(double* milliseconds, const Stage& stage) {
  const auto start = std::chrono::steady_clock::now();
  stage();
  *milliseconds += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

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
        live(k, p.preprocess, pyramid_levels(p.tracking), b, with_color),
        model(make_pyramid(k, pyramid_levels(p.tracking), b)),
        volume(p.volume, k, b, with_color),
        world_from_camera(initial_pose) {}

  TrackingResult initialise();
  TrackingResult register_frame() const;
  Image<std::uint8_t> explain(const SE3& estimate) const;

  Parameters parameters;
  Pinhole camera;
  Backend& backend;
  LiveFrame live;
  DepthPyramid model;  ///< what `world_from_model` sees of the volume
  Volume volume;
  SE3 world_from_camera;  ///< the last pose that was believed
  SE3 world_from_model;
  bool initialised = false;
};

Pipeline::Pipeline(const Parameters& parameters, const Pinhole& camera, Backend& backend, const SE3& initial_pose,
                   bool with_color)
    : state_(
          std::make_unique<State>(parameters, camera, backend, initial_pose, with_color && parameters.volume.color)) {}
Pipeline::~Pipeline() = default;

FrameReport Pipeline::process(const Frame& frame, Image<std::uint8_t>* pixel_use) {
  State& s = *state_;
  FrameReport report;
  report.index = frame.index;
  report.time = frame.time;

  // 1. Surface measurement: metres, smoothing, pyramid, normals.
  timed(&report.milliseconds.preprocess, [&] { s.live.prepare(frame); });

  // 2. Sensor pose estimation against the prediction from the last pose; the first frame defines the world.
  timed(&report.milliseconds.track, [&] { report.tracking = s.initialised ? s.register_frame() : s.initialise(); });
  report.world_from_camera = s.world_from_camera;
  if (pixel_use != nullptr && !report.tracking.iterations.empty())
    *pixel_use = s.explain(report.tracking.world_from_camera);
  if (report.tracking.status == TrackingStatus::lost) return report;  // not fused, and the model is kept
  report.world_from_camera = s.world_from_camera = report.tracking.world_from_camera;

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

TrackingResult Pipeline::State::register_frame() const {
  if (!live.has_depth()) {
    TrackingResult result;
    result.reason = LostReason::no_depth;
    result.world_from_camera = world_from_camera;
    return result;
  }
  TrackingInput input;
  input.world_from_model = world_from_model;
  input.world_from_camera_seed = world_from_camera;
  return track(backend, live.pyramid(), model, input, parameters.tracking);
}

Image<std::uint8_t> Pipeline::State::explain(const SE3& estimate) const {
  const Plane<std::uint8_t> use(camera.width, camera.height,
                                [&](std::size_t bytes) { return backend.allocate(bytes); });
  kernels::IcpInput in = icp_input(live.pyramid().front(), model.front());
  set_gates(parameters.tracking, world_from_model.inverse() * estimate, &in);
  backend.run(kernels::ExplainPixels{in, use.view()});
  return download(backend, use);
}

Mesh Pipeline::extract_mesh() const { return state_->volume.extract_mesh(state_->parameters.mesh); }

SE3 Pipeline::world_from_volume() const { return state_->volume.world_from_volume(); }
double Pipeline::volume_side() const { return state_->volume.side(); }

}  // namespace plumbline
