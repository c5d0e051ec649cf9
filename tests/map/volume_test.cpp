// The volume as a whole: any size, placement, and starting afresh.
#include "map/volume.h"
#include "map/reference_volume.h"
#include "plumbline/error.h"
#include "plumbline/image.h"
#include "plumbline/mesh.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "support/lane_types.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

class AnyVolume : public test::LaneTest {};

bool is_forgotten(const kernels::BrickMap& view) {
  const int slots = view.slots();
  const auto zero = [](std::int32_t word) { return word == 0; };
  return std::all_of(view.states(), view.states() + slots, zero) &&
         std::all_of(view.voxels_of(0), view.voxels_of(slots), zero) &&
         (!view.has_color() || std::all_of(view.colors_of(0), view.colors_of(slots), zero));
}

/// A sphere in the middle of a volume of side 1 m whose corner is the world's origin, seen from outside.
struct Scene {
  sim::AnalyticScene scene{{sim::sphere({0.5, 0.5, 0.5}, 0.3)}};
  Pinhole camera = test::pinhole(160, 120);
  SE3 world_from_camera = sim::look_at({-0.4, 0.2, 0.9}, {0.5, 0.5, 0.5});
  Image<float> depth = test::view_of(scene, camera, world_from_camera).depth;
};

TEST_P(AnyVolume, SizesNeedNotBeMultiplesOfALane) {
  const Scene scene;
  for (const int resolution : {8, 20, 24, 56, 136}) {
    VolumeParameters parameters = preset("kinectfusion").volume;
    parameters.resolution = resolution;
    parameters.side = 1;
    parameters.truncation = std::max(0.04, 2.5 / resolution);
    Volume volume(parameters, scene.camera, backend(), false);
    volume.place({SE3(), 1});
    const int rounded = (resolution + 7) / 8 * 8;
    ASSERT_EQ(volume.view().resolution(), rounded);
    EXPECT_NEAR(volume.voxel_size(), 1.0 / rounded, 1e-7);
    EXPECT_NEAR(volume.side(), 1, 1e-6);
    volume.integrate(test::to_plane(backend(), scene.depth), nullptr, scene.camera, scene.world_from_camera);

    test::ReferenceVolume reference(rounded / 8, 1, parameters.truncation, parameters.max_weight);
    reference.integrate(scene.depth, scene.camera, scene.world_from_camera.inverse());
    const test::ReferenceVolume::Comparison comparison = reference.compare(volume.view());
    EXPECT_EQ(comparison.wrong, 0) << resolution;
    EXPECT_GT(comparison.seen, rounded) << resolution;

    // It can be predicted from and meshed too.
    DepthPyramid model = make_pyramid(scene.camera, 3, backend());
    volume.predict(scene.world_from_camera, RaycastRange(), &model);
    const Mesh mesh = volume.extract_mesh(MeshParameters());
    const Image<float> predicted = download(backend(), model.front().depth);
    const auto hits = std::count_if(predicted.pixels.begin(), predicted.pixels.end(), [](float z) { return z > 0; });
    for (const DepthLevel& level : model) EXPECT_EQ(test::dirty_padding(backend(), level), 0);
    if (resolution < 20) continue;  // a voxel of an eighth of a metre shows no sphere
    EXPECT_GT(hits, 500) << resolution;
    ASSERT_GT(mesh.triangles.size(), 50u) << resolution;
    std::vector<double> errors;
    for (const Mesh::Float3& p : mesh.positions) errors.push_back(scene.scene.distance({p.x, p.y, p.z}));
    EXPECT_LT(test::quantile(errors, 0.5), 0.5 / rounded) << resolution;
  }
}

TEST_P(AnyVolume, PlacingItAgainForgetsWhatWasFused) {
  const Scene scene;
  VolumeParameters parameters = preset("kinectfusion").volume;
  parameters.resolution = 64;
  parameters.truncation = 0.05;
  Volume volume(parameters, scene.camera, backend(), true);
  volume.place({SE3(), 1});
  EXPECT_TRUE(is_forgotten(volume.view()));
  Image<std::int32_t> colors(scene.camera.width, scene.camera.height);
  std::fill(colors.pixels.begin(), colors.pixels.end(), 0x405060);
  const Plane<std::int32_t> color = test::to_plane(backend(), colors);
  const auto depth = test::to_plane(backend(), scene.depth);
  volume.integrate(depth, &color, scene.camera, scene.world_from_camera);
  ASSERT_FALSE(is_forgotten(volume.view()));
  const Mesh first = volume.extract_mesh(MeshParameters());
  ASSERT_FALSE(first.triangles.empty());

  volume.place({SE3(), 1});
  EXPECT_TRUE(is_forgotten(volume.view()));
  EXPECT_TRUE(volume.extract_mesh(MeshParameters()).triangles.empty());

  // The same again gives the same.
  volume.integrate(depth, &color, scene.camera, scene.world_from_camera);
  EXPECT_EQ(volume.extract_mesh(MeshParameters()).positions.size(), first.positions.size());
}

TEST_P(AnyVolume, PlacingItAgainForgetsEvenWhenTheLastFrameChangedNothing) {
  const Scene scene;
  VolumeParameters parameters = preset("kinectfusion").volume;
  parameters.resolution = 64;
  parameters.truncation = 0.05;
  Volume volume(parameters, scene.camera, backend(), false);
  volume.place({SE3(), 1});
  volume.integrate(test::to_plane(backend(), scene.depth), nullptr, scene.camera, scene.world_from_camera);
  const auto black = test::make_plane<float>(backend(), scene.camera.width, scene.camera.height);
  volume.integrate(black, nullptr, scene.camera, scene.world_from_camera);
  ASSERT_EQ(volume.bricks_updated(), 0);
  ASSERT_FALSE(is_forgotten(volume.view()));
  volume.place({SE3(), 1});
  EXPECT_TRUE(is_forgotten(volume.view()));
}

TEST_P(AnyVolume, ItsPlaceAndSideAreThoseGiven) {
  const SE3 pose = test::Random(4).motion(1, 3);
  Volume volume(VolumeParameters{.resolution = 64}, test::pinhole(160, 120), backend(), false);
  volume.place({pose, 2.5});
  EXPECT_NEAR(volume.side(), 2.5, 1e-6);
  EXPECT_EQ(volume.world_from_volume().translation(), pose.translation());
  EXPECT_EQ(volume.world_from_volume().rotation(), pose.rotation());
}

PLUMBLINE_ON_EVERY_LANE_TYPE(AnyVolume);

// ---- placement ------------------------------------------------------------------------------------------------------

TEST(VolumePlacement, FrontIsCentredOnTheFirstCamerasAxis) {
  const SE3 pose = test::Random(9).motion(0.7, 2);
  const Pinhole camera = test::pinhole(160, 120);
  VolumeParameters parameters = preset("kinectfusion").volume;
  parameters.side = 2;
  parameters.offset = 0.25;
  const VolumePlacementResult placement = place_volume(parameters, camera, pose, Image<float>(160, 120));
  EXPECT_EQ(placement.side, 2);
  const SE3 camera_from_volume = pose.inverse() * placement.world_from_volume;
  EXPECT_LT((camera_from_volume.rotation() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_LT((camera_from_volume * Eigen::Vector3d(1, 1, 0) - Eigen::Vector3d(0, 0, 0.5)).norm(), 1e-12);
}

TEST(VolumePlacement, FitHoldsTheFirstFramesPoints) {
  const sim::AnalyticScene scene{{sim::sphere({0.2, -0.1, 2}, 0.4)}};
  const Pinhole camera = test::pinhole(160, 120);
  const SE3 pose = test::Random(3).motion(1, 1);
  sim::AnalyticScene moved = scene;
  moved.primitives[0].world_from_local = pose * scene.primitives[0].world_from_local;
  Image<float> depth = test::view_of(moved, camera, pose).depth;
  for (const int x : {0, 80}) depth.at(x, 0) = 7.5f;  // strays do not decide
  VolumeParameters parameters = preset("kinectfusion").volume;
  parameters.placement = VolumePlacement::fit;
  parameters.side = 5;
  const VolumePlacementResult placement = place_volume(parameters, camera, pose, depth);
  EXPECT_GT(placement.side, 0.8);
  EXPECT_LT(placement.side, 1.3);
  int points = 0, inside = 0;
  for (int v = 1; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) {
      if (depth.at(u, v) == 0) continue;
      const Eigen::Vector3d p =
          placement.world_from_volume.inverse() * (pose * (test::pixel_ray(camera, u, v) * double{depth.at(u, v)}));
      ++points;
      inside += p.minCoeff() > 0 && p.maxCoeff() < placement.side;
    }
  }
  EXPECT_GT(points, 1000);
  EXPECT_GT(inside, 0.98 * points);
  parameters.side = 0.5;  // the most that it may take
  EXPECT_EQ(place_volume(parameters, camera, pose, depth).side, 0.5);
}

TEST(VolumePlacement, FitNeedsReadings) {
  VolumeParameters parameters = preset("kinectfusion").volume;
  parameters.placement = VolumePlacement::fit;
  EXPECT_THROW(place_volume(parameters, test::pinhole(160, 120), SE3(), Image<float>(160, 120)), Error);
}

}  // namespace
}  // namespace plumbline
