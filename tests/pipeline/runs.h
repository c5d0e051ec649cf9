// A whole run of the pipeline over frames, as the tests look at it.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "backend/backend.h"
#include "plumbline/frame.h"
#include "plumbline/mesh.h"
#include "plumbline/parameters.h"
#include "plumbline/pinhole.h"
#include "plumbline/pipeline.h"
#include "plumbline/se3.h"
#include "plumbline/trajectory.h"

namespace plumbline::test {

/// For images of 160 × 120 pixels: all levels are tracked, and the voxels are larger.
inline Parameters parameters_for_quarter_size() {
  Parameters parameters;
  parameters.tracking.finest_level = 0;
  parameters.volume.resolution = 160;
  parameters.volume.placement = VolumePlacement::fit;
  return parameters;
}

struct Run {
  Trajectory trajectory;  ///< tracked frames only
  std::vector<FrameReport> reports;
  Mesh mesh;
  int lost = 0;
};

/// Frames 0 … count − 1 from `frame`, through a pipeline of its own.
inline Run run_pipeline(const Parameters& parameters, const Pinhole& camera, int count,
                        const std::function<Frame(int)>& frame, int threads = 0, const SE3& initial_pose = SE3(),
                        bool with_color = false, const std::string& backend_name = "cpu") {
  const auto backend = make_backend(backend_name, threads);
  Pipeline pipeline(parameters, camera, *backend, initial_pose, with_color);
  Run run;
  for (int i = 0; i < count; ++i) {
    run.reports.push_back(pipeline.process(frame(i)));
    const FrameReport& report = run.reports.back();
    if (report.tracking.status == TrackingStatus::lost) {
      ++run.lost;
    } else {
      run.trajectory.push_back({report.time, report.world_from_camera});
    }
  }
  run.mesh = pipeline.extract_mesh();
  return run;
}

}  // namespace plumbline::test
