#include "sim/depth_camera.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/frame.h"
#include "plumbline/mesh.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "sim/mesh_builder.h"

namespace plumbline::sim {
namespace {

using Eigen::Vector3d;

constexpr Pinhole kCamera{525, 525, 319.5f, 239.5f, 640, 480};

/// A plane through (0, 0, z) before a camera at the origin, turned about the vertical, 12 m across.
Mesh plane(double z, double incidence) {
  MeshBuilder m;
  m.cell = 20;
  m.sheet(turned(0, 0, z, 0, std::numbers::pi - incidence, 0), {6, 6}, plain({90, 120, 150}));
  return m.mesh();
}

/// Everything but the noise of the depth itself switched off.
DepthCameraOptions axial_only() {
  DepthCameraOptions options;
  options.camera = kCamera;
  options.depth_scale = 50000;
  options.model.axial = 1;  // the publication's own figures
  options.model.signal = 0;
  options.model.lateral = 0;
  options.model.edge_holes = 0;
  options.model.distortion = 0;
  options.model.shadow = false;
  options.model.max_range = 1.3;  // what 16 bits hold at this scale
  options.color = false;
  return options;
}

double root_mean_square(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

/// Deviations of the readings from the exact depth within 60 px of the centre, over several frames.
std::vector<double> deviations(const Mesh& mesh, DepthCameraOptions options) {
  const DepthCamera camera(mesh, options);
  options.noise = false;
  const Frame exact = DepthCamera(mesh, options).capture(SE3(), 0);
  std::vector<double> values;
  for (int i = 0; i < 20; ++i) {
    const Frame frame = camera.capture(SE3(), i);
    for (int y = 180; y < 300; ++y)
      for (int x = 260; x < 380; ++x)
        if (frame.depth.at(x, y) != 0)
          values.push_back((frame.depth.at(x, y) - exact.depth.at(x, y)) / options.depth_scale);
  }
  return values;
}

TEST(DepthCamera, ExactDepthOfAPlaneAndASphere) {
  DepthCameraOptions options;
  options.camera = kCamera;
  options.depth_scale = 20000;
  options.noise = false;
  const double tilt = 40 * kRadiansPerDegree, z0 = 1.5;
  const Frame wall = DepthCamera(plane(z0, tilt), options).capture(SE3(), 0);
  MeshBuilder ball;
  ball.blob(stand(0.1, -0.05, 1.2), {0.4, 0.4, 0.4}, plain({1, 2, 3}), 2, 400);
  const Frame sphere = DepthCamera(ball.mesh(), options).capture(SE3(), 0);
  double worst_plane = 0, worst_sphere = 0;
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      const Vector3d ray((x - double{kCamera.cx}) / kCamera.fx, (y - double{kCamera.cy}) / kCamera.fy, 1);
      const Vector3d normal(std::sin(tilt), 0, -std::cos(tilt));
      const double plane_z = normal.z() * z0 / normal.dot(ray);
      if (plane_z > 0 && plane_z < 3)
        worst_plane = std::max(worst_plane, std::abs(wall.depth.at(x, y) / 20000.0 - plane_z));
      const Vector3d centre(0.1, -0.05, 1.2);
      const double a = ray.squaredNorm(), b = ray.dot(centre), c = centre.squaredNorm() - 0.16, root = b * b - a * c;
      // Near the silhouette a facet's chord is seen edge-on.
      if (root > 0.02)
        worst_sphere = std::max(worst_sphere, std::abs(sphere.depth.at(x, y) / 20000.0 - (b - std::sqrt(root)) / a));
    }
  }
  EXPECT_GT(worst_plane, 0);  // readings are rounded
  EXPECT_LT(worst_plane, 1e-4);
  EXPECT_LT(worst_sphere, 1e-4);
}

TEST(DepthCamera, AxialNoiseFollowsTheMeasuredModel) {
  struct Case {
    double z, incidence, scale;
  };
  for (const auto& [z, degrees, scale] :
       {Case{0.6, 0, 50000}, Case{1.0, 0, 30000}, Case{2.0, 0, 20000}, Case{3.0, 0, 15000}, Case{1.0, 40, 20000},
        Case{1.0, 60, 15000}, Case{2.0, 60, 10000}}) {
    DepthCameraOptions options = axial_only();
    options.depth_scale = scale;
    options.model.max_range = 4.9;
    const Mesh mesh = plane(z, degrees * kRadiansPerDegree);
    const std::vector<double> measured = deviations(mesh, options);
    ASSERT_GT(measured.size(), 100'000U) << z << " m, " << degrees << " degrees";
    // The plane's depth and incidence vary over the window: the expectation is the model's mean square over it.
    options.noise = false;
    const Frame exact = DepthCamera(mesh, options).capture(SE3(), 0);
    double expected = 0;
    int count = 0;
    const Vector3d normal(std::sin(degrees * kRadiansPerDegree), 0, -std::cos(degrees * kRadiansPerDegree));
    for (int y = 180; y < 300; y += 4) {
      for (int x = 260; x < 380; ++x) {
        const Vector3d ray((x - double{kCamera.cx}) / kCamera.fx, (y - double{kCamera.cy}) / kCamera.fy, 1);
        const double sigma = axial_sigma(exact.depth.at(x, y) / scale, std::acos(-normal.dot(ray.normalized())));
        expected += sigma * sigma;
        ++count;
      }
    }
    EXPECT_NEAR(root_mean_square(measured) / std::sqrt(expected / count), 1, 0.06)
        << z << " m, " << degrees << " degrees";
  }
}

TEST(DepthCamera, FormulasAreThoseOfTheirPaper) {
  // Nguyen, Izadi, Lovell 2012, eq. 1 and 5, worked by hand.
  EXPECT_NEAR(axial_sigma(0.4, 0), 0.0012, 1e-12);
  EXPECT_NEAR(axial_sigma(2.0, 0), 0.0012 + 0.0019 * 2.56, 1e-12);
  EXPECT_NEAR(axial_sigma(1.0, std::numbers::pi / 4), 0.0012 + 0.0019 * 0.36 + 0.0001, 1e-12);
  EXPECT_NEAR(lateral_sigma(0), 0.8, 1e-12);
  EXPECT_NEAR(lateral_sigma(std::numbers::pi / 4), 0.835, 1e-12);
  EXPECT_TRUE(std::isfinite(axial_sigma(1, std::numbers::pi / 2)));
}

TEST(DepthCamera, DistortionIsTheSensorsOwnAndSmooth) {
  DepthCameraOptions options = axial_only();
  options.model.axial = 0;
  options.model.disparity_step = 0;
  options.model.distortion = 0.15;
  const Mesh mesh = plane(1.2, 0);
  const DepthCamera camera(mesh, options);
  const Frame first = camera.capture(SE3(), 0), second = camera.capture(SE3(), 1);
  EXPECT_EQ(first.depth.pixels, second.depth.pixels);
  double squares = 0, steepest = 0;
  for (int y = 0; y < 480; ++y) {
    for (int x = 1; x < 640; ++x) {
      const auto disparity = [&](int u) { return 580 * 0.075 / (first.depth.at(u, y) / options.depth_scale); };
      squares += std::pow(disparity(x) - 580 * 0.075 / 1.2, 2) / (480 * 639);
      steepest = std::max(steepest, std::abs(disparity(x) - disparity(x - 1)));
    }
  }
  EXPECT_NEAR(std::sqrt(squares), 0.15, 0.06);  // of one pattern; unit rms is that of many
  EXPECT_LT(steepest, 0.01);
  options.seed = 2;
  EXPECT_NE(DepthCamera(mesh, options).capture(SE3(), 0).depth.pixels, first.depth.pixels);
}

TEST(DepthCamera, ReadingsAreStepsOfDisparity) {
  const DepthCameraOptions options = axial_only();
  const Frame frame = DepthCamera(plane(1.1, 0.3), options).capture(SE3(), 3);
  int readings = 0;
  for (const std::uint16_t reading : frame.depth.pixels) {
    if (reading == 0) continue;
    ++readings;
    const double steps = 580 * 0.075 / (reading / options.depth_scale) / 0.125;
    EXPECT_NEAR(steps, std::round(steps), 0.005);
  }
  EXPECT_GT(readings, 100'000);
}

TEST(DepthCamera, HolesGrowWithTheIncidence) {
  DepthCameraOptions options = axial_only();
  options.model.max_range = 4.9;
  options.depth_scale = 10000;
  for (const double degrees : {30.0, 60.0, 72.0, 78.0, 82.0}) {
    const Mesh mesh = plane(1.5, degrees * kRadiansPerDegree);
    const DepthCamera camera(mesh, options);
    const Vector3d normal(std::sin(degrees * kRadiansPerDegree), 0, -std::cos(degrees * kRadiansPerDegree));
    double holes = 0, expected = 0;
    int count = 0;
    for (int i = 0; i < 20; ++i) {
      const Frame frame = camera.capture(SE3(), i);
      for (int y = 140; y < 340; ++y) {
        for (int x = 310; x < 330; ++x) {
          const Vector3d ray((x - double{kCamera.cx}) / kCamera.fx, (y - double{kCamera.cy}) / kCamera.fy, 1);
          expected += grazing_hole_rate(options.model, std::acos(-normal.dot(ray.normalized())));
          holes += frame.depth.at(x, y) == 0 ? 1 : 0;
          ++count;
        }
      }
    }
    EXPECT_NEAR(holes / count, expected / count, 0.03) << degrees;
  }
}

/// A square before a wall.
Mesh square_before_wall() {
  MeshBuilder m;
  m.cell = 20;
  m.sheet(turned(0, 0, 2.0, 0, std::numbers::pi, 0), {4, 4}, plain({200, 200, 200}));
  m.box(stand(0, 0, 1.0), {0.2, 0.2, 0.001}, plain({50, 50, 50}));
  return m.mesh();
}

TEST(DepthCamera, TheProjectorsShadowLiesToTheLeft) {
  DepthCameraOptions options = axial_only();
  options.depth_scale = 5000;
  options.model.max_range = 5;
  options.model.axial = 0;
  options.model.shadow = true;
  const Frame frame = DepthCamera(square_before_wall(), options).capture(SE3(), 0);
  int holes = 0;
  for (int x = 0; x < 640; ++x) holes += frame.depth.at(x, 240) == 0 ? 1 : 0;
  // Between the disparities of the square and the wall: 525 · 0.075 · (1/1 − 1/2) pixels.
  EXPECT_NEAR(holes, 525 * 0.075 * 0.5, 1.5);
  const int left = static_cast<int>(319.5 - 0.2 * 525);
  EXPECT_EQ(frame.depth.at(left - 8, 240), 0);
  EXPECT_NE(frame.depth.at(left + 10, 240), 0);
  EXPECT_NE(frame.depth.at(static_cast<int>(319.5 + 0.2 * 525) + 8, 240), 0);
}

TEST(DepthCamera, EdgesTrembleByTheLateralDeviation) {
  DepthCameraOptions options = axial_only();
  options.depth_scale = 5000;
  options.model.max_range = 5;
  options.model.axial = 0;
  options.model.lateral = 1;
  const DepthCamera camera(square_before_wall(), options);
  std::vector<double> shifts;
  const double edge = 319.5 + 0.2 * 525 / 0.999;
  for (int i = 0; i < 40; ++i) {
    const Frame frame = camera.capture(SE3(), i);
    for (int y = 150; y < 330; ++y) {
      int near = 0;
      for (int x = 320; x < 480; ++x) near += frame.depth.at(x, y) < 7500 ? 1 : 0;
      shifts.push_back(319.5 + near - edge);
    }
  }
  EXPECT_NEAR(root_mean_square(shifts), lateral_sigma(0), 0.25);
}

TEST(DepthCamera, RangeIsRespected) {
  DepthCameraOptions options;
  options.camera = kCamera;
  for (const double z : {0.3, 5.5})
    for (const std::uint16_t reading : DepthCamera(plane(z, 0), options).capture(SE3(), 0).depth.pixels)
      ASSERT_EQ(reading, 0);
}

/// A camera that pans.
SE3 panning(double t) { return {so3::exp(Vector3d(0, 2 * t, 0)), Vector3d::Zero()}; }

TEST(DepthCamera, RowsFollowOneAnotherInARollingShutter) {
  DepthCameraOptions options = axial_only();
  options.noise = false;
  options.depth_scale = 5000;
  options.readout = 0.03;
  const Mesh mesh = square_before_wall();
  const Frame rolling = DepthCamera(mesh, options).capture(panning, 0, 0);
  options.readout = 0;
  const DepthCamera still(mesh, options);
  for (const int y : {170, 240, 320}) {
    const Frame at_once = still.capture(panning(0.03 * ((y + 0.5) / 480 - 0.5)), 0);
    for (int x = 0; x < 640; ++x) ASSERT_EQ(rolling.depth.at(x, y), at_once.depth.at(x, y)) << x << " " << y;
  }
}

TEST(DepthCamera, ExposureMixesTheTwoSidesOfAMovingEdgeOnly) {
  DepthCameraOptions options = axial_only();
  options.noise = false;
  options.depth_scale = 5000;
  options.exposure = 0.02;
  options.exposure_samples = 8;
  const Frame blurred = DepthCamera(square_before_wall(), options).capture(panning, 0, 0);
  int mixed = 0;
  for (const std::uint16_t reading : blurred.depth.pixels) mixed += reading > 5600 && reading < 9000 ? 1 : 0;
  EXPECT_EQ(mixed, 0) << "no depth between the surfaces is invented";
  options.exposure = 0;
  const Frame sharp = DepthCamera(square_before_wall(), options).capture(panning, 0, 0);
  int changed = 0;
  for (std::size_t i = 0; i < sharp.depth.pixels.size(); ++i)
    changed += std::abs(sharp.depth.pixels[i] - blurred.depth.pixels[i]) > 2000 ? 1 : 0;
  EXPECT_GT(changed, 500);
}

TEST(DepthCamera, SameSeedSameBytesInAnyOrderAndThread) {
  const Mesh mesh = square_before_wall();
  DepthCameraOptions options;
  options.camera = {131, 131, 79.5f, 59.5f, 160, 120};
  const DepthCamera camera(mesh, options);
  std::vector<Frame> one(6), many(6);
  for (int i = 0; i < 6; ++i) one[static_cast<std::size_t>(i)] = camera.capture(panning, 0.01 * i, i);
  // More than the machine may have.
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 4);
  tbb::task_arena(4).execute([&] {
    tbb::parallel_for(
        0, 6, [&](int i) { many[static_cast<std::size_t>(5 - i)] = camera.capture(panning, 0.01 * (5 - i), 5 - i); });
  });
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(one[i].depth.pixels, many[i].depth.pixels);
    EXPECT_EQ(one[i].color.pixels, many[i].color.pixels);
  }
  options.seed = 2;
  EXPECT_NE(DepthCamera(mesh, options).capture(panning, 0, 0).depth.pixels, one[0].depth.pixels);
  EXPECT_NE(camera.capture(panning, 0, 1).depth.pixels, one[0].depth.pixels);
}

TEST(DepthCamera, RefusesWhatIsOutOfRange) {
  const Mesh mesh = plane(1, 0);
  DepthCameraOptions options;
  options.depth_scale = 0;
  EXPECT_THROW(DepthCamera(mesh, options), Error);
  options = {};
  options.camera.width = 0;
  EXPECT_THROW(DepthCamera(mesh, options), Error);
  options = {};
  options.model.correlation = 0.5;
  EXPECT_THROW(DepthCamera(mesh, options), Error);
  Mesh broken = mesh;
  broken.triangles.push_back({0, 1, 1000});
  EXPECT_THROW(DepthCamera(broken, DepthCameraOptions()), Error);
}

}  // namespace
}  // namespace plumbline::sim
