#include "lab/stages.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/median.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "plumbline/sequence.h"
#include "plumbline/trajectory.h"
#include "sim/analytic_scene.h"

namespace plumbline::app {
namespace {

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

double median_of(const std::function<double()>& time, double seconds) {
  std::vector<double> times;
  time();  // what is made at the first time is not counted
  const auto start = std::chrono::steady_clock::now();
  while (times.size() < 3 || milliseconds_since(start) < 1e3 * seconds) times.push_back(time());
  return median(std::move(times));
}

double median_milliseconds(const std::function<void()>& run, double seconds) {
  return median_of(
      [&] {
        const auto begin = std::chrono::steady_clock::now();
        run();
        return milliseconds_since(begin);
      },
      seconds);
}

StageFrames simulated_frames(int width, int height, int warm_up) {
  const float focal = 525.0f * static_cast<float>(width) / 640;
  StageFrames result{
      {focal, focal, 0.5f * static_cast<float>(width - 1), 0.5f * static_cast<float>(height - 1), width, height}, {}};
  const sim::AnalyticScene scene = sim::desk_corner();
  const Trajectory path = sim::orbit();
  for (int i = 0; i <= warm_up; ++i) {
    const StampedPose& pose = path.at(static_cast<std::size_t>(i));
    result.frames.push_back(sim::render(scene, result.camera, pose.world_from_camera, pose.time, 5000, false));
  }
  return result;
}

StageFrames recorded_frames(const std::string& folder, int warm_up) {
  const auto sequence = open_sequence(folder, {});
  StageFrames result{sequence->info().camera, {}};
  for (int i = 0; i <= warm_up && i < sequence->size(); ++i) result.frames.push_back(sequence->read(i));
  return result;
}

StageScene::StageScene(const StageFrames& frames, const Parameters& parameters, const std::string& backend, int threads)
    : frames_(frames),
      parameters_(parameters),
      backend_(make_backend(backend, threads)),
      live_(frames.camera, parameters.preprocess, pyramid_levels(parameters.tracking), *backend_, false,
            parameters.tracking.finest_level),
      model_(make_pyramid(frames.camera, static_cast<int>(parameters.tracking.iterations.size()), *backend_,
                          parameters.tracking.finest_level)),
      filtered_(frames.camera, *backend_),
      volume_(parameters.volume, frames.camera, *backend_, false) {
  for (std::size_t i = 0; i + 1 < frames.frames.size(); ++i) {
    live_.prepare(frames.frames[i]);
    if (i == 0)
      volume_.place(place_volume(parameters.volume, frames.camera, pose_, download(*backend_, live_.raw_depth())));
    else
      pose_ = register_live().world_from_camera;
    volume_.integrate(live_.raw_depth(), nullptr, frames.camera, pose_);
    volume_.predict(pose_, raycast_range(parameters.preprocess.max_depth), &model_);
  }
  live_.prepare(frames.frames.back());
  upload(*backend_, download(*backend_, live_.raw_depth()), filtered_.depth);
  volume_.integrate(live_.raw_depth(), nullptr, frames.camera, pose_);
}

TrackingResult StageScene::register_live() const {
  RegistrationInput input;
  input.world_from_model = input.world_from_camera_seed = pose_;
  return register_frame(*backend_, live_.pyramid(), model_, input, parameters_.tracking);
}

std::vector<Stage> StageScene::stages() {
  std::vector<Stage> stages;
  add_preprocessing(stages);
  add_registration(stages);
  add_mapping(stages);
  return stages;
}

Stage StageScene::frame(const std::vector<Stage>& stages) {
  const auto run = [this] {
    live_.prepare(frames_.frames.back());
    register_live();
    volume_.integrate(live_.raw_depth(), nullptr, frames_.camera, pose_);
    volume_.predict(pose_, raycast_range(parameters_.preprocess.max_depth), &model_);
  };
  double bytes = 0;
  for (const Stage& stage : stages) bytes += stage.is_whole ? stage.bytes : 0;
  return {"a frame at once", run, pixels(), "px", bytes, false};
}

double StageScene::wall(const Stage& stage, double seconds) const {
  return median_milliseconds(
      [&] {
        stage.run();
        backend_->wait();
      },
      seconds);
}

double StageScene::device(const Stage& stage, double seconds) const {
  return median_of([&] { return backend_->milliseconds(stage.run); }, seconds);
}

void StageScene::add_preprocessing(std::vector<Stage>& stages) {
  const PreprocessParameters& p = parameters_.preprocess;
  // Readings, metres for fusion, metres and normals for tracking.
  stages.push_back(
      {"preprocess", [this] { live_.prepare(frames_.frames.back()); }, pixels(), "px", pixels() * (2 + 4 + 4 + 12)});
  const kernels::BilateralFilter filter = bilateral_filter(live_.raw_depth(), filtered_.depth);
  if (p.bilateral)
    stages.push_back(
        {"  bilateral filter", [this, filter] { backend_->run(filter); }, pixels(), "px", pixels() * 8, false});
  stages.push_back({"  plane normals",
                    [this] { estimate_plane_normals(*backend_, filtered_, kNormalRadius, kNormalDepthGate); }, pixels(),
                    "px", pixels() * 16, false});
}

void StageScene::add_registration(std::vector<Stage>& stages) {
  const std::size_t missing = live_.pyramid().size() - model_.size();
  double iterations_bytes = 0;
  std::vector<Stage> parts;
  for (std::size_t level = missing; level < live_.pyramid().size(); ++level) {
    kernels::IcpInput in = icp_input(live_.pyramid()[level], model_[level - missing]);
    registration_rules(parameters_.tracking).set_gates(SE3(), 0, &in);
    const double px = static_cast<double>(in.live_depth.width) * in.live_depth.height;
    constexpr double kBytes = 2 * 16;  // depth and normal, live and predicted
    parts.push_back({fmt::format("  ICP iteration {}x{}", in.live_depth.width, in.live_depth.height),
                     [this, in] { backend_->reduce(kernels::IcpReduce{in}); }, px, "px", px * kBytes, false});
    iterations_bytes += px * kBytes * parameters_.tracking.iterations.at(live_.pyramid().size() - 1 - level);
  }
  stages.push_back({"track", [this] { register_live(); }, pixels(), "px", iterations_bytes});
  stages.insert(stages.end(), parts.begin(), parts.end());
}

void StageScene::add_mapping(std::vector<Stage>& stages) {
  const double voxels = static_cast<double>(volume_.bricks_updated()) * kernels::kBrickVoxels;
  stages.push_back({"integrate", [this] { volume_.integrate(live_.raw_depth(), nullptr, frames_.camera, pose_); },
                    voxels, "voxel", voxels * 8 + pixels() * 4});
  const Pinhole& predicted = model_.front().camera;
  const double rays = static_cast<double>(predicted.width) * predicted.height;
  stages.push_back({"ray cast",
                    [this] { volume_.predict(pose_, raycast_range(parameters_.preprocess.max_depth), &model_); }, rays,
                    "px", voxels * 4 + rays * 16});
}

}  // namespace plumbline::app
