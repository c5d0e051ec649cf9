// Time of every stage on one frame at 640×480 and a 512³ volume: on a real sequence if its folder is in
// PLUMBLINE_BENCH_SEQUENCE, else on the analytic desk. The argument of each benchmark is the number of threads.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <map>
#include <memory>
#include <string>

#include "backend/cpu/cpu.h"
#include "io/sequence.h"
#include "mapping/volume.h"
#include "sim/analytic_scene.h"
#include "tracking/live_frame.h"
#include "tracking/tracker.h"

namespace plumbline {
namespace {

constexpr int kWarmUpFrames = 20;

/// The frames to work on, held in memory.
struct Scan {
  Pinhole camera{525, 525, 319.5f, 239.5f, 640, 480};
  std::vector<Frame> frames;

  Scan() {
    if (const char* folder = std::getenv("PLUMBLINE_BENCH_SEQUENCE")) {
      const auto sequence = open_sequence(folder, {});
      camera = sequence->info().camera;
      for (int i = 0; i <= kWarmUpFrames && i < sequence->size(); ++i) frames.push_back(sequence->read(i));
      return;
    }
    const sim::AnalyticScene scene = sim::desk_corner();
    const Trajectory path = sim::orbit();
    for (std::size_t i = 0; i <= kWarmUpFrames; ++i)
      frames.push_back(sim::render(scene, camera, path[i].world_from_camera, path[i].time));
  }
};

const Scan& scan() {
  static const Scan instance;
  return instance;
}

/// A volume with a few frames in it, the prediction from the last pose, and one more frame prepared.
struct Scene {
  explicit Scene(int threads)
      : backend(make_cpu_backend(threads)),
        live(scan().camera, parameters.preprocess, pyramid_levels(parameters.tracking), *backend, true),
        model(make_pyramid(scan().camera, pyramid_levels(parameters.tracking), *backend)),
        volume(parameters.volume, scan().camera, *backend, true) {
    for (std::size_t i = 0; i + 1 < scan().frames.size(); ++i) {
      live.prepare(scan().frames[i]);
      if (i == 0) {
        volume.place(place_volume(parameters.volume, scan().camera, pose, download(*backend, live.raw_depth())));
      } else {
        pose = register_live().world_from_camera;
      }
      volume.integrate(live.raw_depth(), live.color(), scan().camera, pose);
      volume.predict(pose, parameters.raycast, &model);
    }
    live.prepare(scan().frames.back());
  }

  TrackingResult register_live() const {
    TrackingInput input;
    input.world_from_model = input.world_from_camera_seed = pose;
    return track(*backend, live.pyramid(), model, input, parameters.tracking);
  }

  Parameters parameters;
  std::unique_ptr<Backend> backend;
  LiveFrame live;
  DepthPyramid model;
  Volume volume;
  SE3 pose;
};

/// One scene per number of threads; a benchmark leaves it as it found it, but for weights.
Scene& scene(const benchmark::State& state) {
  static std::map<std::int64_t, std::unique_ptr<Scene>> scenes;
  std::unique_ptr<Scene>& entry = scenes[state.range(0)];
  if (!entry) entry = std::make_unique<Scene>(static_cast<int>(state.range(0)));
  return *entry;
}

void preprocess(benchmark::State& state) {
  Scene& s = scene(state);
  for (auto _ : state) s.live.prepare(scan().frames.back());
}

void bilateral_filter(benchmark::State& state) {
  const Scene& s = scene(state);
  const PreprocessParameters& p = s.parameters.preprocess;
  const DepthLevel out(scan().camera, *s.backend);
  const auto inverse = [](double sigma) { return static_cast<float>(0.5 / (sigma * sigma)); };
  for (auto _ : state)
    s.backend->run(kernels::BilateralFilter{read_only(s.live.raw_depth()), out.depth.view(), p.bilateral_radius,
                                            inverse(p.bilateral_sigma_space), inverse(p.bilateral_sigma_range)});
}

void plane_normals(benchmark::State& state) {
  const Scene& s = scene(state);
  const DepthLevel out(scan().camera, *s.backend);
  for (auto _ : state)
    s.backend->run(kernels::PlaneNormals{read_only(s.live.pyramid().front().depth), out.normals(), scan().camera,
                                         s.parameters.preprocess.normal_radius,
                                         static_cast<float>(s.parameters.preprocess.normal_depth_gate)});
}

void icp_iteration(benchmark::State& state) {
  const Scene& s = scene(state);
  const auto level = static_cast<std::size_t>(state.range(1));
  kernels::IcpInput in = icp_input(s.live.pyramid()[level], s.model[level]);
  set_gates(s.parameters.tracking, SE3(), 0, &in);
  for (auto _ : state) benchmark::DoNotOptimize(s.backend->reduce(kernels::IcpReduce{in}));
}

void track_19_iterations(benchmark::State& state) {
  const Scene& s = scene(state);
  for (auto _ : state) benchmark::DoNotOptimize(s.register_live());
}

void integrate(benchmark::State& state) {
  Scene& s = scene(state);
  for (auto _ : state) s.volume.integrate(s.live.raw_depth(), nullptr, scan().camera, s.pose);
  state.counters["bricks"] = s.volume.bricks_updated();
}

void integrate_with_color(benchmark::State& state) {
  Scene& s = scene(state);
  if (s.live.color() == nullptr) return state.SkipWithError("the sequence has no colour");
  for (auto _ : state) s.volume.integrate(s.live.raw_depth(), s.live.color(), scan().camera, s.pose);
}

void raycast(benchmark::State& state) {
  Scene& s = scene(state);
  for (auto _ : state) s.volume.predict(s.pose, s.parameters.raycast, &s.model);
}

void extract_mesh(benchmark::State& state) {
  const Scene& s = scene(state);
  for (auto _ : state) benchmark::DoNotOptimize(s.volume.extract_mesh(s.parameters.mesh));
}

void threads(benchmark::internal::Benchmark* b) {
  b->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();
}

void threads_and_levels(benchmark::internal::Benchmark* b) {
  b->ArgsProduct({{1, 2}, {0, 1, 2}})->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime();
}

BENCHMARK(preprocess)->Apply(threads);
BENCHMARK(bilateral_filter)->Apply(threads);
BENCHMARK(plane_normals)->Apply(threads);
BENCHMARK(icp_iteration)->Apply(threads_and_levels);
BENCHMARK(track_19_iterations)->Apply(threads);
BENCHMARK(integrate)->Apply(threads);
BENCHMARK(integrate_with_color)->Apply(threads);
BENCHMARK(raycast)->Apply(threads);
BENCHMARK(extract_mesh)->Apply(threads);

}  // namespace
}  // namespace plumbline

BENCHMARK_MAIN();
