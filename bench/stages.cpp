// Time of every stage on one frame at 640×480 and a 512³ volume: on a real sequence if its folder is in
// PLUMBLINE_BENCH_SEQUENCE, else on the analytic desk. PLUMBLINE_BENCH_BACKEND may choose the instruction set, as in
// cpu:avx2+fma, PLUMBLINE_BENCH_PRESET the parameters. The argument of each benchmark is the number of threads.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <list>
#include <string>

#include "lab/stages.h"

namespace {

using namespace plumbline;

constexpr int kWarmUpFrames = 20;

std::string setting(const char* name, const char* otherwise) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : otherwise;
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  const std::string sequence = setting("PLUMBLINE_BENCH_SEQUENCE", "");
  const app::StageFrames frames =
      sequence.empty() ? app::simulated_frames(640, 480, kWarmUpFrames) : app::recorded_frames(sequence, kWarmUpFrames);
  std::list<app::StageScene> scenes;
  for (const int threads : {1, 2}) {
    scenes.emplace_back(frames, preset(setting("PLUMBLINE_BENCH_PRESET", "kinectfusion")),
                        setting("PLUMBLINE_BENCH_BACKEND", "auto"), threads);
    for (const app::Stage& stage : scenes.back().stages()) {
      const std::string name = stage.name.substr(stage.name.find_first_not_of(' ')) + "/" + std::to_string(threads);
      benchmark::RegisterBenchmark(name.c_str(),
                                   [stage](benchmark::State& state) {
                                     for (auto _ : state) stage.run();
                                   })
          ->Unit(benchmark::kMillisecond)
          ->MeasureProcessCPUTime()
          ->UseRealTime();
    }
  }
  benchmark::RunSpecifiedBenchmarks();
}
