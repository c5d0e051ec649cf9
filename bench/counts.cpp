// Runs every stage of a small frame once between marks for callgrind, which counts instructions: the same number on
// every machine, where times are not. tests/check_counts.py compares them with those of tests/counts.json.
//
// usage: valgrind --tool=callgrind --instr-atstart=no bench_counts INSTRUCTION_SET
#include <valgrind/callgrind.h>

#include <cstdio>
#include <exception>

#include "lab/stages.h"

int main(int argc, char** argv) {
  using namespace plumbline;
  try {
    const app::StageFrames frames = app::simulated_frames(160, 120, 2);
    for (const char* name : {"kinectfusion", "plumbline"}) {
      Parameters parameters = preset(name);
      parameters.volume.resolution = 128;
      app::StageScene scene(frames, parameters, std::string("cpu:") + (argc > 1 ? argv[1] : "avx2+fma"), 1);
      for (const app::Stage& stage : scene.stages()) {
        const std::string label = std::string(name) + ": " + stage.name;
        stage.run();  // what is made at the first time is not counted
        CALLGRIND_START_INSTRUMENTATION;
        CALLGRIND_ZERO_STATS;
        stage.run();
        CALLGRIND_DUMP_STATS_AT(label.c_str());
        CALLGRIND_STOP_INSTRUMENTATION;
      }
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
