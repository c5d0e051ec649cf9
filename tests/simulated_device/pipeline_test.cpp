// Whole reconstructions on the simulated device: odd images, frames without readings and frames that are lost, volumes
// whose border the surface crosses. Every device gives the same bits, and nearly what the CPU gives.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/runs.h"
#include "plumbline/angles.h"
#include "plumbline/frame.h"
#include "simulated_device/devices.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

struct Scan {
  Pinhole camera = test::pinhole(83, 61);
  SE3 first;
  std::vector<Frame> frames;

  Scan() {
    const sim::AnalyticScene scene = sim::desk_corner();
    const Trajectory path = sim::orbit();
    first = path.front().world_from_camera;
    for (int i = 0; i < 6; ++i) {
      const StampedPose& pose = path[static_cast<std::size_t>(i)];
      frames.push_back(sim::render(scene, camera, pose.world_from_camera, pose.time));
      frames.back().index = i;
    }
    // Nothing is seen, and a wall close to the lens.
    std::fill(frames[2].depth.pixels.begin(), frames[2].depth.pixels.end(), std::uint16_t{0});
    std::fill(frames[4].depth.pixels.begin(), frames[4].depth.pixels.end(), std::uint16_t{2000});
  }
};

struct Case {
  const char* name;
  const char* preset;
  int first_seed;
  void (*change)(Parameters*);
};
const Case kCases[] = {
    {"Kinectfusion", "kinectfusion", 0, [](Parameters*) {}},
    {"Plumbline", "plumbline", 1, [](Parameters* p) { p->tracking.relocalise_after = 0; }},
    {"Paper", "paper", 2, [](Parameters*) {}},
    {"AtTheBorder", "kinectfusion", 3,
     [](Parameters* p) {
       p->tracking.min_inlier_fraction = 0.02;
       p->volume.side = 1.8;
       p->volume.offset = 0.2;  // a part of the scene, whose surface goes through the faces
       p->volume.resolution = 44;
       p->volume.truncation = 0.08;
     }},
};

class SimulatedPipeline : public testing::TestWithParam<Case> {
 protected:
  static test::Run run(const std::string& backend) {
    static const Scan scan;
    Parameters parameters = preset(GetParam().preset);
    parameters.volume.resolution = 64;
    parameters.volume.side = 3.2;
    parameters.volume.truncation = 0.12;
    parameters.volume.offset = -0.1;
    parameters.mesh.min_weight = 1;
    GetParam().change(&parameters);
    return test::run_pipeline(
        parameters, scan.camera, static_cast<int>(scan.frames.size()),
        [](int i) { return scan.frames[static_cast<std::size_t>(i)]; }, 1, scan.first, false, backend);
  }
};

void expect_near(const test::Run& a, const test::Run& b) {
  ASSERT_EQ(a.reports.size(), b.reports.size());
  for (std::size_t i = 0; i < a.reports.size(); ++i) {
    SCOPED_TRACE(i);
    EXPECT_EQ(a.reports[i].tracking.status, b.reports[i].tracking.status);
    EXPECT_EQ(a.reports[i].tracking.reason, b.reports[i].tracking.reason);
    const SE3 between = a.reports[i].world_from_camera.inverse() * b.reports[i].world_from_camera;
    EXPECT_LE(between.translation().norm(), 2e-4);
    EXPECT_LE(so3::angle(between.rotation()), radians(0.01));
  }
  const auto triangles = static_cast<double>(b.mesh.triangles.size());
  EXPECT_NEAR(static_cast<double>(a.mesh.triangles.size()), triangles, 0.01 * triangles);
}

void expect_same_bits(const test::Run& a, const test::Run& b) {
  for (std::size_t i = 0; i < a.reports.size(); ++i) {
    EXPECT_EQ(a.reports[i].world_from_camera.rotation(), b.reports[i].world_from_camera.rotation()) << i;
    EXPECT_EQ(a.reports[i].world_from_camera.translation(), b.reports[i].world_from_camera.translation()) << i;
  }
  ASSERT_EQ(a.mesh.positions.size(), b.mesh.positions.size());
  EXPECT_EQ(
      std::memcmp(a.mesh.positions.data(), b.mesh.positions.data(), a.mesh.positions.size() * sizeof(Mesh::Float3)), 0);
}

TEST_P(SimulatedPipeline, SameBitsOnEveryDeviceAndThoseOfTheCpuNearly) {
  const test::Run on_cpu = run("cpu");
  EXPECT_EQ(on_cpu.reports[2].tracking.status, TrackingStatus::lost);
  EXPECT_EQ(on_cpu.reports[4].tracking.status, TrackingStatus::lost);
  EXPECT_EQ(on_cpu.reports[5].tracking.status, TrackingStatus::tracked);
  EXPECT_GT(on_cpu.mesh.triangles.size(), 500u);
  std::optional<test::Run> first;
  test::on_devices(GetParam().first_seed, 3, [&] {
    const test::Run found = run("cuda");
    expect_near(found, on_cpu);
    if (first)
      expect_same_bits(*first, found);
    else
      first = found;
  });
}
INSTANTIATE_TEST_SUITE_P(Cases, SimulatedPipeline, testing::ValuesIn(kCases),
                         [](const auto& test) { return test.param.name; });

/// What the kernels that were launched take, against every generation that the backend is compiled for.
TEST(SimulatedLimits, HoldOnEveryGeneration) {
  static const Scan scan;
  Parameters parameters = preset("paper");
  parameters.volume.resolution = 32;
  parameters.volume.truncation = 0.3;
  test::run_pipeline(
      parameters, scan.camera, 2, [](int i) { return scan.frames[static_cast<std::size_t>(i)]; }, 1, scan.first, false,
      "cuda");
  const std::vector<simulated::Launch> launches = simulated::take_launches();
  EXPECT_GT(launches.size(), 12u);
  for (const simulated::Launch& launch : launches) {
    SCOPED_TRACE(launch.kernel);
    for (const simulated::Limits& limits : simulated::known_limits()) {
      EXPECT_LE(launch.threads, std::min(1024, limits.threads_of_processor)) << limits.capability;
      EXPECT_LE(launch.touched_shared + launch.dynamic_shared, std::size_t{48} << 10);
      if (!launch.cooperative) continue;
      // Three at a time on a processor, as the kernel's bounds ask for (`__launch_bounds__(256, 3)`).
      EXPECT_LE(3 * launch.threads, limits.threads_of_processor) << limits.capability;
      EXPECT_LE(3 * (launch.touched_shared + launch.dynamic_shared + limits.shared_reserved),
                limits.shared_of_processor);
    }
  }
}

}  // namespace
}  // namespace plumbline
