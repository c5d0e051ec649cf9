// A recording frame by frame: reconstruct RECORDING leaves mesh.ply and trajectory.txt.
#include <exception>
#include <iostream>
#include <optional>

#include "plumbline/files.h"
#include "plumbline/pipeline.h"
#include "plumbline/prefetch.h"
#include "plumbline/sequence.h"

int main(int argc, char** argv) try {
  const auto sequence = plumbline::open_sequence(argc > 1 ? argv[1] : ".");
  const auto backend = plumbline::make_backend();
  plumbline::Parameters parameters = plumbline::preset("plumbline");
  parameters.volume.resolution = 256;
  plumbline::Pipeline pipeline(parameters, sequence->info().camera, *backend);

  std::vector<int> all(static_cast<std::size_t>(sequence->size()));
  for (int i = 0; i < sequence->size(); ++i) all[static_cast<std::size_t>(i)] = i;
  plumbline::ReadableFrames frames(*sequence, all);  // decoded ahead, in a thread of their own
  plumbline::Trajectory trajectory;
  while (const std::optional<plumbline::Frame> frame = frames.next()) {
    const plumbline::FrameReport report = pipeline.process(*frame);
    if (plumbline::has_pose(report.tracking.status)) trajectory.push_back({report.time, report.world_from_camera});
  }
  std::cout << trajectory.size() << " of " << sequence->size() << " frames tracked\n";
  plumbline::write_mesh("mesh.ply", pipeline.extract_mesh());
  plumbline::write_tum_trajectory("trajectory.txt", trajectory);
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
