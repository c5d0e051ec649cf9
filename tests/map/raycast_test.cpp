// Prediction from the volume against the exact surfaces that were fused, and the model's pyramid by brute force.
#include <tbb/global_control.h>

#include <cmath>

#include "map/reference_volume.h"
#include "map/volume.h"
#include "plumbline/angles.h"
#include "plumbline/image.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "plumbline/trajectory.h"
#include "support/lane_types.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

constexpr double kSteepest = 60 * kRadiansPerDegree;

/// A scene and the volume around it, fused from some poses.
struct Setting {
  sim::AnalyticScene scene;
  VolumeParameters parameters = preset("kinectfusion").volume;
  SE3 world_from_volume;
  std::vector<SE3> fused_from;

  double voxel() const { return parameters.side / parameters.resolution; }
};

VolumeParameters volume_parameters(int resolution, double side, double truncation) {
  VolumeParameters parameters = preset("kinectfusion").volume;
  parameters.resolution = resolution;
  parameters.side = side;
  parameters.truncation = truncation;
  return parameters;
}

const Eigen::Vector3d kCentre(0.5, 0.5, 0.5);

Setting sphere_setting(int poses) {
  Setting s{{{sim::sphere(kCentre, 0.3)}}, volume_parameters(64, 1, 0.04), SE3(), {}};
  for (int i = 0; i < poses; ++i) {
    const double around = 2 * std::numbers::pi * i / poses;
    const Eigen::Vector3d offset(1.1 * std::cos(around), 1.1 * std::sin(around), 0.5 * std::cos(2 * around + 0.5));
    s.fused_from.push_back(sim::look_at(kCentre + offset, kCentre));
  }
  return s;
}

Setting plane_setting() {
  return {{{sim::plane(kCentre, Eigen::Vector3d(0.3, -1, 0.2))}},
          volume_parameters(64, 1, 0.04),
          SE3(),
          {sim::look_at({0.6, -0.8, 0.7}, kCentre)}};
}

Setting desk_setting() {
  Setting s{
      sim::desk_corner(), volume_parameters(128, 3.2, 0.08), SE3(Eigen::Matrix3d::Identity(), {-1.5, -1.5, -0.2}), {}};
  const Trajectory path = sim::orbit();
  for (std::size_t i = 0; i < 120; i += 20) s.fused_from.push_back(path[i].world_from_camera);
  return s;
}

/// How a prediction differs from the exact view.
struct Errors {
  std::vector<double> depth, normal;  ///< metres along the axis; radians
  int predicted = 0, invented = 0, expected = 0;
};

class RaycastTest : public test::LaneTest {
 protected:
  Volume fuse(const Setting& s) const {
    Volume volume(s.parameters, fusing_camera_, backend(), false);
    volume.place({s.world_from_volume, s.parameters.side});
    for (const SE3& pose : s.fused_from)
      volume.integrate(test::to_plane(backend(), test::view_of(s.scene, fusing_camera_, pose).depth), nullptr,
                       fusing_camera_, pose);
    return volume;
  }

  test::View predict(const Volume& volume, const SE3& world_from_camera, const Pinhole& camera) const {
    DepthPyramid model = make_pyramid(camera, 3, backend());
    volume.predict(world_from_camera, RaycastRange(), &model);
    for (const DepthLevel& level : model) EXPECT_EQ(test::dirty_padding(backend(), level), 0);
    return test::to_view(backend(), model.front());
  }

  /// Where the surface is seen under less than 60° from its normal: beyond, projective distances say little.
  static Errors compare(const test::View& predicted, const test::View& exact, const Pinhole& camera) {
    Errors errors;
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        const bool is_predicted = predicted.depth.at(u, v) > 0, exists = exact.depth.at(u, v) > 0;
        EXPECT_EQ(is_predicted, predicted.normal(u, v).norm() > 0.5) << "depth and normal come together";
        errors.predicted += is_predicted;
        errors.invented += is_predicted && !exists;
        const double cosine = -exact.normal(u, v).dot(test::pixel_ray(camera, u, v).normalized());
        if (!exists || cosine < std::cos(kSteepest)) continue;
        ++errors.expected;
        if (!is_predicted) continue;
        EXPECT_NEAR(predicted.normal(u, v).norm(), 1, 1e-4);
        errors.depth.push_back(std::abs(double{predicted.depth.at(u, v)} - double{exact.depth.at(u, v)}));
        errors.normal.push_back(test::angle_between(predicted.normal(u, v), exact.normal(u, v)));
      }
    }
    return errors;
  }

  int predicted_pixels(const Volume& volume, const SE3& world_from_camera) const {
    const test::View view = predict(volume, world_from_camera, camera_);
    return static_cast<int>(
        std::count_if(view.depth.pixels.begin(), view.depth.pixels.end(), [](float z) { return z != 0; }));
  }

  /// Predicted with few pixels, but fused with many: a voxel takes the reading of one pixel, and a pixel must not be
  /// much coarser than a voxel.
  Pinhole camera_ = test::pinhole(160, 120), fusing_camera_ = test::pinhole(320, 240);
};

TEST_P(RaycastTest, SphereFromWhereItWasFused) {
  const Setting s = sphere_setting(1);
  const Volume volume = fuse(s);
  const SE3& pose = s.fused_from.front();
  const Errors errors = compare(predict(volume, pose, camera_), test::view_of(s.scene, camera_, pose), camera_);
  EXPECT_GT(errors.expected, 2000);
  EXPECT_GT(static_cast<double>(errors.depth.size()), 0.99 * errors.expected);
  EXPECT_LT(test::quantile(errors.depth, 0.5), 0.15 * s.voxel());
  EXPECT_LT(test::quantile(errors.depth, 0.99), 0.5 * s.voxel());
  EXPECT_LT(test::quantile(errors.normal, 0.5), 2 * kRadiansPerDegree);
}

TEST_P(RaycastTest, SphereFromElsewhere) {
  const Setting s = sphere_setting(8);
  const Volume volume = fuse(s);
  for (const Eigen::Vector3d& direction : {Eigen::Vector3d(0.9, 0.4, 0.3), {-0.5, 0.8, 0.1}, {0.1, -1, -0.2}}) {
    const SE3 pose = sim::look_at(kCentre + direction, kCentre);
    const Errors errors = compare(predict(volume, pose, camera_), test::view_of(s.scene, camera_, pose), camera_);
    EXPECT_GT(errors.expected, 2000);
    EXPECT_GT(static_cast<double>(errors.depth.size()), 0.97 * errors.expected);
    EXPECT_LT(test::quantile(errors.depth, 0.5), 0.15 * s.voxel());
    EXPECT_LT(test::quantile(errors.depth, 0.99), 0.5 * s.voxel());
    EXPECT_LT(test::quantile(errors.normal, 0.5), 4 * kRadiansPerDegree)
        << "eight views, each slanted differently, blur the projective distance";
  }
}

TEST_P(RaycastTest, ASphereWrittenAsItsExactDistance) {
  // No fusion between the oracle and the rays: what is left is the trilinear interpolation of a curved field.
  const Setting s = sphere_setting(1);
  Volume volume(s.parameters, camera_, backend(), false);
  volume.place({SE3(), 1});
  test::write_distance(volume.view(), [&](const Eigen::Vector3d& p) { return (p - kCentre).norm() - 0.3; });
  for (const Eigen::Vector3d& direction : {Eigen::Vector3d(0.9, 0.4, 0.3), {-0.3, 0.3, 0.1}, {0.1, -1, -0.2}}) {
    const SE3 pose = sim::look_at(kCentre + direction, kCentre);
    const Errors errors = compare(predict(volume, pose, camera_), test::view_of(s.scene, camera_, pose), camera_);
    EXPECT_EQ(errors.depth.size(), static_cast<std::size_t>(errors.expected));
    EXPECT_GT(errors.expected, 2000);
    EXPECT_LT(test::quantile(errors.depth, 0.5), 0.03 * s.voxel());
    EXPECT_LT(test::quantile(errors.depth, 0.99), 0.05 * s.voxel());
    EXPECT_LT(test::quantile(errors.depth, 1), 0.6 * s.voxel());
    EXPECT_LT(test::quantile(errors.normal, 0.99), 0.2 * kRadiansPerDegree);
  }
}

TEST_P(RaycastTest, Plane) {
  const Setting s = plane_setting();
  const Volume volume = fuse(s);
  const SE3 elsewhere = sim::look_at({0.3, -0.6, 0.5}, kCentre);
  for (const SE3& pose : {s.fused_from.front(), elsewhere}) {
    const Errors errors = compare(predict(volume, pose, camera_), test::view_of(s.scene, camera_, pose), camera_);
    EXPECT_GT(errors.depth.size(), 4000u);
    EXPECT_LT(test::quantile(errors.depth, 0.5), 0.15 * s.voxel());
    EXPECT_LT(test::quantile(errors.depth, 0.99), 0.5 * s.voxel());
    EXPECT_LT(test::quantile(errors.normal, 0.5), 2 * kRadiansPerDegree);
  }
}

TEST_P(RaycastTest, Desk) {
  const Setting s = desk_setting();
  const Volume volume = fuse(s);
  const SE3 pose = sim::orbit()[50].world_from_camera;
  const Errors errors = compare(predict(volume, pose, camera_), test::view_of(s.scene, camera_, pose), camera_);
  EXPECT_GT(static_cast<double>(errors.depth.size()), 0.8 * errors.expected);
  EXPECT_LT(test::quantile(errors.depth, 0.5), 0.15 * s.voxel());
  EXPECT_LT(test::quantile(errors.depth, 0.9), 0.5 * s.voxel()) << "edges and thin parts are rounded";
  EXPECT_LT(test::quantile(errors.normal, 0.5), 2 * kRadiansPerDegree);
}

TEST_P(RaycastTest, ACameraWithYUpAndAnOddSize) {
  const Setting s = sphere_setting(8);
  const Volume volume = fuse(s);
  Pinhole camera = test::pinhole(131, 97);
  camera.fy = -camera.fy;
  camera.cx += 7;
  const SE3 pose = sim::look_at(kCentre + Eigen::Vector3d(0.9, 0.4, 0.3), kCentre);
  const Errors errors = compare(predict(volume, pose, camera), test::view_of(s.scene, camera, pose), camera);
  EXPECT_GT(errors.depth.size(), 1500u);
  EXPECT_LT(test::quantile(errors.depth, 0.99), 0.5 * s.voxel());
  EXPECT_LT(test::quantile(errors.normal, 0.5), 4 * kRadiansPerDegree);
}

TEST_P(RaycastTest, AVolumeThatLiesAskewPredictsTheSame) {
  Setting s = sphere_setting(1);
  const SE3 turn = test::Random(2).motion(1.1, 0.8);
  s.world_from_volume = turn;
  s.scene.primitives[0].world_from_local = turn * s.scene.primitives[0].world_from_local;
  s.fused_from.front() = turn * s.fused_from.front();
  const Volume volume = fuse(s);
  const SE3& pose = s.fused_from.front();
  const Errors errors = compare(predict(volume, pose, camera_), test::view_of(s.scene, camera_, pose), camera_);
  EXPECT_GT(static_cast<double>(errors.depth.size()), 0.99 * errors.expected);
  EXPECT_LT(test::quantile(errors.depth, 0.5), 0.15 * s.voxel());
  EXPECT_LT(test::quantile(errors.normal, 0.5), 2 * kRadiansPerDegree);
}

TEST_P(RaycastTest, ACameraInsideTheVolume) {
  Setting s = plane_setting();
  s.fused_from = {sim::look_at({0.5, 0.1, 0.5}, {0.5, 0.6, 0.5})};
  const Volume volume = fuse(s);
  const SE3& pose = s.fused_from.front();
  const Errors errors = compare(predict(volume, pose, camera_), test::view_of(s.scene, camera_, pose), camera_);
  EXPECT_GT(static_cast<double>(errors.depth.size()), 0.85 * errors.expected)
      << "all but the image's rim, where a voxel's neighbours were not seen";
  EXPECT_EQ(errors.invented, 0);
  EXPECT_LT(test::quantile(errors.depth, 0.99), 0.5 * s.voxel());
}

TEST_P(RaycastTest, NothingIsPredictedFromBehind) {
  const Setting s = plane_setting();
  const Volume volume = fuse(s);
  EXPECT_GT(predicted_pixels(volume, s.fused_from.front()), 5000);
  EXPECT_EQ(predicted_pixels(volume, sim::look_at({0.5, 1.8, 0.5}, kCentre)), 0) << "from outside";
  EXPECT_EQ(predicted_pixels(volume, sim::look_at({0.5, 0.95, 0.5}, kCentre)), 0) << "from within the volume";
}

TEST_P(RaycastTest, NothingIsPredictedElsewhere) {
  const Setting s = sphere_setting(4);
  const Volume volume = fuse(s);
  EXPECT_EQ(
      predicted_pixels(volume, sim::look_at(kCentre + Eigen::Vector3d(2, 0, 0), kCentre + Eigen::Vector3d(4, 0, 0))), 0)
      << "away from the volume";
  EXPECT_EQ(predicted_pixels(volume, sim::look_at({3, 3, 3}, {3, 0, 3.1})), 0) << "past it";
  EXPECT_EQ(predicted_pixels(volume, sim::look_at({14, 0.5, 0.5}, kCentre)), 0) << "beyond the greatest distance";
  Volume empty(s.parameters, camera_, backend(), false);
  EXPECT_EQ(predicted_pixels(empty, s.fused_from.front()), 0);
}

TEST_P(RaycastTest, RaysAlongTheAxesOfTheVolume) {
  // Directions with exact zeros: the middle ray's slabs divide by them.
  Setting s{{{sim::plane({0.5, 0.5, 0.6}, {0, 0, -1})}}, volume_parameters(64, 1, 0.06), SE3(), {}};
  Pinhole camera = camera_;
  camera.cx = 80;
  camera.cy = 60;
  s.fused_from = {SE3(Eigen::Matrix3d::Identity(), {0.5, 0.5, -0.3})};
  const Volume volume = fuse(s);
  for (const double x : {0.5, 0.5 + 0.5 / 64, 0.125}) {  // on a voxel's face, its centre, a brick's face
    const test::View view = predict(volume, SE3(Eigen::Matrix3d::Identity(), {x, x, -0.3}), camera);
    EXPECT_NEAR(view.depth.at(80, 60), 0.9f, 0.002f) << x;
    EXPECT_LT(test::angle_between(view.normal(80, 60), {0, 0, -1}), 0.5 * kRadiansPerDegree);
  }
}

TEST_P(RaycastTest, OnlyBetweenTheLimitsOfDistance) {
  const Setting s = sphere_setting(1);
  const Volume volume = fuse(s);
  const SE3& pose = s.fused_from.front();
  RaycastRange parameters;
  parameters.max_distance = 0.9;
  DepthPyramid model = make_pyramid(camera_, 1, backend());
  volume.predict(pose, parameters, &model);
  const Image<float> near_part = download(backend(), model.front().depth);
  EXPECT_GT(std::count_if(near_part.pixels.begin(), near_part.pixels.end(), [](float z) { return z > 0; }), 200);
  for (const float z : near_part.pixels) ASSERT_LT(z, 0.9 + s.voxel());
  parameters.min_distance = 2;
  parameters.max_distance = 3;
  volume.predict(pose, parameters, &model);
  for (const float z : download(backend(), model.front().depth).pixels)
    ASSERT_EQ(z, 0) << "the last prediction is gone";
}

// ---- the model's pyramid --------------------------------------------------------------------------------------------

struct CoarsePixel {
  double depth = 0;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
};

CoarsePixel decimated(const test::View& fine, int x, int y, double range) {
  CoarsePixel pixel;
  double low = 1e9, high = 0;
  for (int k = 0; k < 4; ++k) {
    const int u = 2 * x + k % 2, v = 2 * y + k / 2;
    const double z = double{fine.depth.at(u, v)};
    low = std::min(low, z);
    high = std::max(high, z);
    pixel.depth += z / 4;
    pixel.normal += fine.normal(u, v);
  }
  if (low == 0 || high - low > range) return {};
  pixel.normal.normalize();
  return pixel;
}

TEST_P(RaycastTest, ModelPyramidMatchesBruteForce) {
  const sim::AnalyticScene scene = sim::desk_corner();
  const Pinhole camera = test::pinhole(161, 121);
  test::View fine = test::view_of(scene, camera, sim::orbit().front().world_from_camera);
  test::Random random(3);
  for (std::size_t i = 0; i < fine.depth.pixels.size(); ++i) {
    if (random.uniform(0, 1) > 0.03) continue;
    fine.depth.pixels[i] = fine.normal_x.pixels[i] = fine.normal_y.pixels[i] = fine.normal_z.pixels[i] = 0;
  }
  const DepthLevel level = test::to_level(backend(), camera, fine);
  DepthLevel coarse_level(camera.level(1), backend());
  backend().run(kernels::DecimateModel{read_only(level.depth), read_only(level.normal_x), read_only(level.normal_y),
                                       read_only(level.normal_z), coarse_level.depth.view(), coarse_level.normals(),
                                       0.09f});
  EXPECT_EQ(test::dirty_padding(backend(), coarse_level), 0);
  const test::View coarse = test::to_view(backend(), coarse_level);
  int with = 0, without = 0;
  for (int y = 0; y < coarse.depth.height; ++y) {
    for (int x = 0; x < coarse.depth.width; ++x) {
      const CoarsePixel expected = decimated(fine, x, y, 0.09);
      ASSERT_NEAR(double{coarse.depth.at(x, y)}, expected.depth, 1e-5) << x << ", " << y;
      ASSERT_LT((coarse.normal(x, y) - expected.normal).norm(), 1e-5) << x << ", " << y;
      (expected.depth > 0 ? with : without)++;
    }
  }
  EXPECT_GT(with, 3000);
  EXPECT_GT(without, 100);
}

TEST_P(RaycastTest, CoarseLevelsLieOnTheSurface) {
  const Setting s = sphere_setting(1);
  const Volume volume = fuse(s);
  DepthPyramid model = make_pyramid(camera_, 3, backend());
  volume.predict(s.fused_from.front(), RaycastRange(), &model);
  for (std::size_t l = 0; l < model.size(); ++l) {
    const test::View view = test::to_view(backend(), model[l]);
    std::vector<double> errors;
    for (int v = 0; v < view.depth.height; ++v) {
      for (int u = 0; u < view.depth.width; ++u) {
        if (view.depth.at(u, v) == 0) continue;
        const Eigen::Vector3d p = test::pixel_ray(model[l].camera, u, v) * double{view.depth.at(u, v)};
        errors.push_back(s.scene.distance(s.fused_from.front() * p));
      }
    }
    EXPECT_GT(errors.size(), 2000u >> (2 * l));
    EXPECT_LT(test::quantile(errors, 0.9), (l == 0 ? 0.3 : 0.5) * s.voxel()) << "level " << l;
  }
}

// ---- other lane types, threads --------------------------------------------------------------------------------------

TEST_P(RaycastTest, AgreesWithPlainFloat) {
  const Setting s = sphere_setting(3);
  const auto scalar = test::make_lanes("scalar");
  const Volume volume = fuse(s);  // one volume for both: memory is the host's
  const SE3 pose = sim::look_at(kCentre + Eigen::Vector3d(0.9, 0.4, 0.3), kCentre);
  const auto cast = [&](const Backend& other) {
    DepthLevel level(camera_, other);
    other.run(kernels::Raycast{volume.view(), level.depth.view(), level.normals(), camera_,
                               to_kernel(volume.world_from_volume().inverse() * pose), 0.05f, 10.0f});
    return test::to_view(other, level);
  };
  const test::View expected = cast(*scalar), actual = cast(backend());
  int hits = 0, differing = 0;
  for (int v = 0; v < camera_.height; ++v) {
    for (int u = 0; u < camera_.width; ++u) {
      hits += expected.depth.at(u, v) > 0;
      differing += std::abs(expected.depth.at(u, v) - actual.depth.at(u, v)) > 0.05 * s.voxel() ||
                   (expected.normal(u, v) - actual.normal(u, v)).norm() > 0.02;
    }
  }
  EXPECT_GT(hits, 2000);
  EXPECT_LT(differing, hits / 50);
}

TEST_P(RaycastTest, SpansChangeNothing) {
  // The desk from within its volume and the sphere from without: bricks around the camera, edges, empty tiles.
  for (const Setting& s : {desk_setting(), sphere_setting(3)}) {
    const Volume volume = fuse(s);
    const SE3 pose = s.fused_from.back();
    DepthPyramid with = make_pyramid(camera_, 1, backend());
    volume.predict(pose, RaycastRange(), &with);
    DepthLevel without(camera_, backend());
    backend().run(kernels::Raycast{volume.view(), without.depth.view(), without.normals(), camera_,
                                   to_kernel(volume.world_from_volume().inverse() * pose), 0.05f, 10.0f});
    const Image<float> expected = download(backend(), without.depth), actual = download(backend(), with[0].depth);
    int hits = 0, differing = 0;
    for (std::size_t i = 0; i < expected.pixels.size(); ++i) {
      hits += expected.pixels[i] > 0;
      differing += std::abs(expected.pixels[i] - actual.pixels[i]) > 0.02 * s.voxel();
    }
    EXPECT_GT(hits, 2000);
    EXPECT_LE(differing, hits / 500) << "rays enter bricks at the same places but for rounding";
  }
}

TEST_P(RaycastTest, SameBitsForAnyNumberOfThreads) {
  const tbb::global_control more_than_cores(tbb::global_control::max_allowed_parallelism, 7);
  const Setting s = sphere_setting(3);
  const auto run = [&](int threads) {
    const auto other = test::make_lanes(GetParam(), threads);
    Volume volume(s.parameters, camera_, *other, false);
    volume.place({s.world_from_volume, s.parameters.side});
    for (const SE3& pose : s.fused_from)
      volume.integrate(test::to_plane(*other, test::view_of(s.scene, camera_, pose).depth), nullptr, camera_, pose);
    DepthPyramid model = make_pyramid(camera_, 2, *other);
    volume.predict(s.fused_from.front(), RaycastRange(), &model);
    return std::pair{download(*other, model[0].depth).pixels, download(*other, model[1].normal_x).pixels};
  };
  const auto one = run(1);
  EXPECT_EQ(one, run(2));
  EXPECT_EQ(one, run(7));
}

PLUMBLINE_ON_EVERY_LANE_TYPE(RaycastTest);

}  // namespace
}  // namespace plumbline
