// The final fusion and the moving window on the simulated device: the same bits in every order of blocks, threads and
// streams, and nearly what the CPU gives.
#include <gtest/gtest.h>

#include <cstring>
#include <optional>
#include <vector>

#include "backend/backend.h"
#include "fusion/fine_map.h"
#include "map/volume.h"
#include "plumbline/backend.h"
#include "plumbline/map.h"
#include "plumbline/mesh.h"
#include "simulated_device/devices.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

struct Scan {
  Pinhole camera = test::pinhole(83, 61);  // no multiple of a block
  std::vector<SE3> poses;
  std::vector<Frame> frames;

  Scan() {
    const sim::AnalyticScene scene = sim::desk_corner();
    const Trajectory path = sim::orbit();
    for (int i = 0; i < 4; ++i) {
      poses.push_back(path[static_cast<std::size_t>(4 * i)].world_from_camera);
      frames.push_back(sim::render(scene, camera, poses.back(), Nanoseconds{i}));
    }
    std::fill(frames[2].depth.pixels.begin(), frames[2].depth.pixels.end(), std::uint16_t{0});
  }
};

const Scan& scan() {
  static const Scan instance;
  return instance;
}

Mesh fused_on(const std::string& backend_name) {
  const auto backend = make_backend(backend_name, 1);
  FineMap map(scan().camera, {0.03, 6000, true, {}}, *backend);
  for (std::size_t i = 0; i < scan().frames.size(); ++i) {
    const FineMap::Fused wanted = i == 2 ? FineMap::Fused::nothing : FineMap::Fused::yes;
    EXPECT_EQ(map.fuse(scan().frames[i], scan().poses[i]), wanted);
  }
  return map.extract_mesh(1);
}

/// A small window that is carried along, and comes back.
Map followed_on(const std::string& backend_name) {
  const auto backend = make_backend(backend_name, 1);
  VolumeParameters parameters;
  parameters.resolution = 40;  // five bricks a side
  parameters.side = 2;
  parameters.offset = 0.2;
  parameters.truncation = 0.15;
  Volume volume(parameters, scan().camera, *backend, false);
  volume.place({scan().poses[0], 2});
  for (const std::size_t i : {0U, 1U, 3U, 0U}) {
    const SE3& pose = scan().poses[i];
    volume.follow({i == 3 ? pose * SE3(Eigen::Matrix3d::Identity(), {1.2, 0, 0.7}) : pose});
    Image<float> metres(scan().camera.width, scan().camera.height);
    for (std::size_t k = 0; k < metres.pixels.size(); ++k)
      metres.pixels[k] = static_cast<float>(scan().frames[i].depth.pixels[k] / scan().frames[i].depth_scale);
    volume.integrate(test::to_plane(*backend, metres), nullptr, scan().camera, pose);
  }
  EXPECT_GT(volume.packed_bricks(), 0u);
  return volume.extract_map();
}

TEST(SimulatedFusion, SameBitsOnEveryDeviceAndThoseOfTheCpuNearly) {
  const Mesh on_cpu = fused_on("cpu");
  ASSERT_GT(on_cpu.triangles.size(), 2000u);
  const auto triangles = static_cast<double>(on_cpu.triangles.size());
  std::optional<Mesh> first;
  test::on_devices(0, 1, [&] {
    const Mesh found = fused_on("cuda");
    EXPECT_NEAR(static_cast<double>(found.triangles.size()), triangles, 0.01 * triangles);
    EXPECT_EQ(found.colors.size(), found.positions.size());
    if (!first) first = found;
    ASSERT_EQ(found.positions.size(), first->positions.size());
    const std::size_t bytes = found.positions.size() * sizeof(Mesh::Float3);
    EXPECT_EQ(std::memcmp(found.positions.data(), first->positions.data(), bytes), 0);
    EXPECT_EQ(std::memcmp(found.normals.data(), first->normals.data(), bytes), 0);
  });
}

TEST(SimulatedFusion, AWindowMovesAlikeOnEveryDevice) {
  const Map on_cpu = followed_on("cpu");
  ASSERT_GT(on_cpu.bricks.size(), 30u);
  std::optional<Map> first;
  test::on_devices(1, 1, [&] {
    const Map found = followed_on("cuda");
    EXPECT_EQ(found.bricks.size(), on_cpu.bricks.size());
    if (!first) first = found;
    EXPECT_EQ(found.distances, first->distances);
    EXPECT_EQ(found.weights, first->weights);
  });
}

}  // namespace
}  // namespace plumbline
