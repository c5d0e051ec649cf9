// A user's program: two pipelines in two threads, over frames of a ball before a wall, and what else the library gives.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <thread>

#include "plumbline/error.h"
#include "plumbline/evaluation.h"
#include "plumbline/files.h"
#include "plumbline/pipeline.h"
#include "plumbline/version.h"

namespace {

constexpr plumbline::Pinhole kCamera{131.25f, 131.25f, 79.5f, 59.5f, 160, 120};
constexpr int kFrames = 8;

/// The camera moves forward by a centimetre a frame; a ball of 0.3 m before a wall at 2 m, both in the world.
plumbline::Frame frame(int index) {
  const double moved = 0.01 * index, radius = 0.3;
  const Eigen::Vector3d centre(0.3, 0.2, 1.2 - moved);
  plumbline::Image<float> depth(kCamera.width, kCamera.height);
  for (int v = 0; v < kCamera.height; ++v) {
    for (int u = 0; u < kCamera.width; ++u) {
      const Eigen::Vector3d ray((u - kCamera.cx) / kCamera.fx, (v - kCamera.cy) / kCamera.fy, 1);
      // |t·ray − centre| = radius
      const double a = ray.dot(ray), b = ray.dot(centre), root = b * b - a * (centre.dot(centre) - radius * radius);
      depth.at(u, v) = static_cast<float>(root > 0 ? (b - std::sqrt(root)) / a : 2 - moved);
    }
  }
  plumbline::Frame frame;
  frame.index = index;
  frame.time = 33'000'000LL * index;
  frame.depth = plumbline::readings_of(depth, frame.depth_scale);
  return frame;
}

struct Result {
  plumbline::Trajectory path;
  plumbline::Mesh mesh;
  plumbline::Map map;
};

void reconstruct(Result* result) {
  plumbline::Parameters parameters;
  parameters.volume.resolution = 128;
  parameters.volume.side = 3;
  const auto backend = plumbline::make_backend("auto", 1);
  plumbline::Pipeline pipeline(parameters, kCamera, *backend);
  for (int i = 0; i < kFrames; ++i) {
    const plumbline::FrameReport report = pipeline.process(frame(i));
    if (plumbline::has_pose(report.tracking.status)) result->path.push_back({report.time, report.world_from_camera});
  }
  result->mesh = pipeline.extract_mesh();
  result->map = pipeline.extract_map();
}

int failures = 0;

void expect(bool holds, const char* what) {
  if (holds) return;
  std::printf("not so: %s\n", what);
  ++failures;
}

bool equal(const plumbline::Trajectory& a, const plumbline::Trajectory& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& p, const auto& q) {
    return p.time == q.time && p.world_from_camera.translation() == q.world_from_camera.translation() &&
           p.world_from_camera.rotation() == q.world_from_camera.rotation();
  });
}

void check_map(const plumbline::Map& map) {
  expect(!map.bricks.empty() && map.distances.size() == map.bricks.size() * plumbline::Map::kBrickVoxels,
         "the map has its bricks' voxels");
  bool seen = false, inside = false;
  for (std::size_t i = 0; i < map.distances.size(); ++i) {
    seen = seen || map.weights[i] >= kFrames;
    inside = inside || map.distances[i] < 0;
    expect(std::abs(map.distances[i]) <= map.truncation * 1.001, "no distance is beyond the truncation");
  }
  expect(seen && inside, "the map was seen from all frames, and has an inside");
}

}  // namespace

int main() {
  Result first, second;
  std::thread other(reconstruct, &second);
  reconstruct(&first);
  other.join();
  expect(first.path.size() == kFrames, "all frames were tracked");
  expect(equal(first.path, second.path), "two threads give the same path");
  expect(!first.mesh.triangles.empty() && first.mesh.positions.size() == second.mesh.positions.size(),
         "two threads give the same surface");
  check_map(first.map);
  plumbline::Trajectory truth;
  for (int i = 0; i < kFrames; ++i)
    truth.push_back({33'000'000LL * i, plumbline::SE3(Eigen::Matrix3d::Identity(), {0, 0, 0.01 * i})});
  const double rmse = plumbline::eval::absolute_trajectory_error(truth, first.path).translation.rmse;
  expect(rmse < 0.01, "the path is within a centimetre of the truth");
  plumbline::write_mesh("ball.ply", first.mesh);
  expect(plumbline::read_mesh("ball.ply").triangles.size() == first.mesh.triangles.size(), "a mesh can be read back");
  try {
    plumbline::read_mesh("missing.ply");
    expect(false, "a missing file is an error");
  } catch (const plumbline::Error& error) {  // of the library's own type, whichever library it came from
    expect(error.where() == "missing.ply", "the error says where");
  }
  std::printf("plumbline %s: %zu frames, %zu triangles, %.1f mm\n", std::string(plumbline::version()).c_str(),
              first.path.size(), first.mesh.triangles.size(), 1e3 * rmse);
  return failures == 0 ? 0 : 1;
}
