// What a run keeps of its frames.
#pragma once

#include <cstddef>
#include <vector>

#include "plumbline/reconstruct.h"
#include "reconstruction/frame_loop.h"

namespace plumbline {

/// Collects the reports and the trajectory. Provisional frames become part of it once their place is confirmed.
class RunRecord : public FrameObserver {
 public:
  /// `run` must outlive it.
  explicit RunRecord(Reconstruction* run) : run_(*run) {}

  void observe(const ProcessedFrame& processed) override;

  /// What is provisional at the end of the run will never be confirmed.
  void take_back();

 private:
  void add_pose(const FrameReport& report) { run_.trajectory.push_back({report.time, report.world_from_camera}); }

  std::vector<std::size_t> provisional_;  ///< frames whose place is not yet confirmed
  Reconstruction& run_;
};

}  // namespace plumbline
