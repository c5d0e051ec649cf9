// The final fusion on a recording whose true surface is known: its own exact depth from exact poses.
#include <algorithm>
#include <string>
#include <vector>

#include "io/trajectory.h"
#include "plumbline/evaluation.h"
#include "plumbline/fusion.h"
#include "plumbline/mesh.h"
#include "plumbline/pipeline.h"
#include "plumbline/se3.h"
#include "plumbline/sequence.h"
#include "plumbline/surface_error.h"
#include "plumbline/trajectory.h"
#include "support/data.h"

namespace plumbline {
namespace {

SE3 pose_at(const Trajectory& truth, Nanoseconds time) {
  for (const StampedPose& pose : truth)
    if (pose.time == time) return pose.world_from_camera;
  ADD_FAILURE() << "no exact pose at " << time;
  return {};
}

/// Adds a frame's readings as a surface: neighbours whose depths differ by less than 5 %.
void add_surface(const Frame& frame, const Pinhole& camera, const SE3& world_from_camera, Mesh* mesh) {
  const auto first = static_cast<std::uint32_t>(mesh->positions.size()),
             width = static_cast<std::uint32_t>(camera.width);
  const auto depth = [&](int u, int v) { return frame.depth.at(u, v) / frame.depth_scale; };
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const auto pixel = static_cast<std::uint32_t>(mesh->positions.size());
      const Eigen::Vector3d ray((u - double{camera.cx}) / double{camera.fx},
                                (v - double{camera.cy}) / double{camera.fy}, 1);
      const Eigen::Vector3f p = (world_from_camera * (depth(u, v) * ray)).cast<float>();
      mesh->positions.push_back({p.x(), p.y(), p.z()});
      if (u == 0 || v == 0) continue;
      const auto [low, high] = std::minmax({depth(u, v), depth(u - 1, v), depth(u, v - 1), depth(u - 1, v - 1)});
      if (!(low > 0) || high > 1.05 * low) continue;
      mesh->triangles.push_back({pixel, pixel - 1, pixel - width});
      mesh->triangles.push_back({pixel - 1, pixel - 1 - width, pixel - width});
    }
  }
  ASSERT_EQ(mesh->positions.size(), first + width * static_cast<std::uint32_t>(camera.height));
}

/// Distances of the vertices to the readings of every fifth frame and to the surface of every twentieth, the nearer
/// one: points alone are some millimetres apart.
eval::Statistics error_of(const Mesh& mesh, const Sequence& sequence, const Trajectory& truth) {
  eval::PointCloud points;
  Mesh surface;
  for (int i = 0; i < sequence.size(); i += 5) {
    const Frame frame = sequence.read(i);
    const SE3 pose = pose_at(truth, frame.time);
    const auto more = eval::back_project(frame, sequence.info().camera, pose, 2);
    points.insert(points.end(), more.begin(), more.end());
    if (i % 20 == 0) add_surface(frame, sequence.info().camera, pose, &surface);
  }
  std::vector<double> errors = eval::distances_to_points(mesh.positions, points);
  const std::vector<double> to_surface = eval::distances_to_mesh(mesh.positions, surface);
  for (std::size_t i = 0; i < errors.size(); ++i) errors[i] = std::min(errors[i], to_surface[i]);
  return eval::statistics(errors);
}

TEST(FinalFusionOfARecording, IsCloserToTheTruthThanTheVolume) {
  PLUMBLINE_DATA_OR_SKIP(folder, "icl_nuim/office_kt3");
  const auto sequence = open_sequence(folder.string(), {});
  const Trajectory truth = read_trajectory(sequence->info().groundtruth);
  const auto backend = make_backend();
  Pipeline pipeline(preset("plumbline"), sequence->info().camera, *backend, pose_at(truth, sequence->time(0)));
  std::vector<FusionFrame> path;
  for (int i = 0; i < sequence->size(); ++i) {
    const FrameReport report = pipeline.process(sequence->read(i));
    if (has_pose(report.tracking.status)) path.push_back({i, report.world_from_camera});
  }
  const auto fused = fuse_frames(*sequence, path);
  ASSERT_TRUE(fused);
  const eval::Statistics before = error_of(pipeline.extract_mesh(), *sequence, truth),
                         after = error_of(fused->mesh, *sequence, truth);
  EXPECT_LE(after.mean, 0.002);
  EXPECT_LE(after.mean, 0.8 * before.mean);
  RecordProperty("mean_before_mm", std::to_string(1e3 * before.mean));
  RecordProperty("mean_after_mm", std::to_string(1e3 * after.mean));
}

}  // namespace
}  // namespace plumbline
