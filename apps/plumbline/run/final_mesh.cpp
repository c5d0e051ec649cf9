#include "run/final_mesh.h"

#include <utility>

#include "cli/progress.h"
#include "reconstruction/final_mesh.h"

namespace plumbline::app {

void fuse_with_progress(const ReconstructionOptions& options, const FrameSource& source,
                        const std::function<bool()>& stopping, Reconstruction* run) {
  FusionOptions fusion = options.fusion;
  fusion.color = options.input.color;
  fusion.threads = options.threads;
  fusion.backend = options.backend;
  fusion.stopping = stopping;
  Progress progress(run->tracked(), options.quiet, {"frame", "fused again", "left out"});
  fusion.on_progress = [&](const FusionProgress& state) { progress.update(state.done, state.done, 0); };
  fuse_finally(std::move(fusion), source, run);
}

}  // namespace plumbline::app
