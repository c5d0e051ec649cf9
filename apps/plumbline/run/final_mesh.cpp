#include "run/final_mesh.h"

#include <algorithm>
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
  fusion.on_progress = [&](const FusionProgress& state) {
    progress.update(state.done, state.done, 0);
    if (options.view)
      options.view->set_phase(ViewPhase::finishing, "Every frame is fused again, for the final mesh.",
                              static_cast<double>(state.done) / std::max(1, run->tracked()));
  };
  fuse_finally(std::move(fusion), source, run);
}

}  // namespace plumbline::app
