// The CUDA backend against the CPU's, on real frames. Skipped where there is no device.
#include <gtest/gtest.h>

#include "backend/cuda/cuda.h"
#include "pipeline/runs.h"
#include "plumbline/angles.h"
#include "plumbline/config.h"
#include "plumbline/error.h"
#include "plumbline/se3.h"
#include "plumbline/sequence.h"
#include "support/data.h"

namespace plumbline {
namespace {

bool is_same(const SE3& a, const SE3& b) { return a.rotation() == b.rotation() && a.translation() == b.translation(); }

class Cuda : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    const BackendInfo info = cuda_info();
    if (!info.available) GTEST_SKIP() << info.description;
  }

  static test::Run run(const Sequence& sequence, const std::string& backend) {
    return test::run_pipeline(
        preset(GetParam()), sequence.info().camera, sequence.size(), [&](int i) { return sequence.read(i); }, 0, SE3(),
        false, backend);
  }
};

TEST_P(Cuda, AgreesWithTheCpuAndRepeatsToTheBit) {
  PLUMBLINE_DATA_OR_SKIP(folder, "tum/rgbd_dataset_freiburg1_xyz");
  const auto sequence = open_sequence(folder.string(), {});
  const test::Run on_cpu = run(*sequence, "cpu"), on_gpu = run(*sequence, "cuda"), again = run(*sequence, "cuda");
  ASSERT_EQ(on_gpu.trajectory.size(), on_cpu.trajectory.size());
  const SE3 between = on_cpu.trajectory.back().world_from_camera.inverse() * on_gpu.trajectory.back().world_from_camera;
  EXPECT_LE(between.translation().norm(), 0.001);
  EXPECT_LE(so3::angle(between.rotation()), radians(0.05));
  for (std::size_t i = 0; i < on_gpu.trajectory.size(); ++i)
    ASSERT_TRUE(is_same(on_gpu.trajectory[i].world_from_camera, again.trajectory[i].world_from_camera)) << i;
  ASSERT_EQ(on_gpu.mesh.positions.size(), again.mesh.positions.size());
  EXPECT_NEAR(static_cast<double>(on_gpu.mesh.triangles.size()), static_cast<double>(on_cpu.mesh.triangles.size()),
              0.01 * static_cast<double>(on_cpu.mesh.triangles.size()));
}

INSTANTIATE_TEST_SUITE_P(Presets, Cuda, testing::Values("kinectfusion", "plumbline"),
                         [](const auto& test) { return test.param; });

TEST(CudaBackend, SaysWhyItIsNotThere) {
  const BackendInfo info = cuda_info();
  if (info.available) GTEST_SKIP() << "there is a device: " << info.description;
  EXPECT_NE(info.description, "");
  EXPECT_THROW(make_cuda_backend(), Error);
  EXPECT_THROW(make_backend("cuda"), Error);
  EXPECT_EQ(make_backend("auto")->name(), "cpu");
}

}  // namespace
}  // namespace plumbline
