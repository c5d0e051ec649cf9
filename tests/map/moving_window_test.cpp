// A window that follows the camera must give what one volume around everything gives.
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include "map/packed_bricks.h"
#include "map/volume.h"
#include "plumbline/map.h"
#include "plumbline/mesh.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "support/lane_types.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

constexpr double kVoxel = 0.05, kSide = 3.2, kWholeSide = 12.8;  // metres
constexpr double kBrick = 8 * kVoxel;
constexpr int kSteps = 11;
const SE3 kWorldFromVolume(Eigen::Matrix3d::Identity(), {-1.6, -1.6, -1.6});
const SE3 kWorldFromWhole(Eigen::Matrix3d::Identity(), {-1.6 - 5 * kBrick, -1.6 - 15 * kBrick, -1.6 - 15 * kBrick});

/// A corridor along x with columns to both sides; seen obliquely, so that all axes matter.
const sim::AnalyticScene& corridor() {
  static const sim::AnalyticScene scene = [] {
    sim::AnalyticScene s{{sim::plane({0, 0, -0.9}, {0, 0, 1}), sim::plane({0, 0, 1.3}, {0, 0, -1}),
                          sim::plane({0, 1.1, 0}, {0, -1, 0}), sim::plane({0, -1, 0}, {0, 1, 0})}};
    for (int i = 0; i < 10; ++i) s.primitives.push_back(sim::sphere({1.0 * i, i % 2 == 0 ? 0.9 : -0.8, 0.3}, 0.35));
    return s;
  }();
  return scene;
}

SE3 pose(int step) {
  const double x = 0.5 * step;
  return sim::look_at({x, 0.1, 0}, {x + 1.2, step % 2 == 0 ? 0.6 : -0.4, -0.1});
}

class MovingWindow : public test::LaneTest {
 protected:
  static VolumeParameters parameters(VolumePlacement placement, double side) {
    VolumeParameters p;
    p.resolution = static_cast<int>(std::lround(side / kVoxel));
    p.side = side;
    p.placement = placement;
    p.truncation = 0.15;
    return p;
  }
  Volume make(VolumePlacement placement) const {
    const bool is_whole = placement == VolumePlacement::given;
    const double side = is_whole ? kWholeSide : kSide;
    Volume volume(parameters(placement, side), camera_, backend(), true);
    volume.place({is_whole ? kWorldFromWhole : kWorldFromVolume, side});
    return volume;
  }
  void fuse(Volume* volume, int step) const {
    volume->follow({pose(step)});
    const Image<float> depth = test::view_of(corridor(), camera_, pose(step)).depth;
    Image<std::int32_t> colors(camera_.width, camera_.height);
    std::fill(colors.pixels.begin(), colors.pixels.end(), 0x102030 + step);
    const Plane<std::int32_t> color = test::to_plane(backend(), colors);
    volume->integrate(test::to_plane(backend(), depth), &color, camera_, pose(step));
  }
  Volume walk(VolumePlacement placement) const {
    Volume volume = make(placement);
    for (int step = 0; step < kSteps; ++step) fuse(&volume, step);
    return volume;
  }

  Pinhole camera_ = test::pinhole(80, 60);
};

using BrickKey = std::array<int, 3>;

/// First word of each brick by its position in the world, counted in bricks from the small volume's corner.
std::map<BrickKey, std::size_t> index_of(const Map& map) {
  const Eigen::Vector3d origin = (map.world_from_map.translation() - kWorldFromVolume.translation()) / kBrick;
  const auto first = [&](int axis) { return static_cast<int>(std::lround(origin[axis])); };
  std::map<BrickKey, std::size_t> result;
  for (std::size_t i = 0; i < map.bricks.size(); ++i) {
    const Map::Brick& b = map.bricks[i];
    const BrickKey key = {b.x / 8 + first(0), b.y / 8 + first(1), b.z / 8 + first(2)};
    EXPECT_TRUE(result.emplace(key, i * Map::kBrickVoxels).second) << "a brick twice";
  }
  return result;
}

/// Vertices at the place of another one, to a tenth of a millimetre.
int doubled_vertices(const Mesh& mesh) {
  std::set<std::array<long, 3>> places;
  for (const Mesh::Float3& p : mesh.positions)
    places.insert({std::lround(1e4f * p.x), std::lround(1e4f * p.y), std::lround(1e4f * p.z)});
  return static_cast<int>(mesh.positions.size() - places.size());
}

/// Of all vertices: towards the middle of the corridor.
double facing_free_space(const Mesh& mesh) {
  double facing = 0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Eigen::Vector3d p(mesh.positions[i].x, mesh.positions[i].y, mesh.positions[i].z);
    const Eigen::Vector3d n(mesh.normals[i].x, mesh.normals[i].y, mesh.normals[i].z);
    facing += n.dot(Eigen::Vector3d(p.x(), 0.05, 0.2) - p) > 0 ? 1 : 0;
  }
  return facing / static_cast<double>(mesh.positions.size());
}

TEST_P(MovingWindow, HoldsWhatAVolumeAroundEverythingHolds) {
  const Volume window = walk(VolumePlacement::follow), whole = walk(VolumePlacement::given);
  ASSERT_GT(window.packed_bricks(), 80u);
  ASSERT_EQ(whole.packed_bricks(), 0u);
  EXPECT_NE(window.world_from_window().translation(), window.world_from_volume().translation());
  const Map moved = window.extract_map(), fixed = whole.extract_map();
  const auto in_fixed = index_of(fixed);
  int compared = 0, wrong = 0;
  for (const auto& [key, first] : index_of(moved)) {
    const auto other = in_fixed.find(key);
    ASSERT_NE(other, in_fixed.end()) << key[0] << ", " << key[1] << ", " << key[2];
    for (std::size_t i = 0; i < Map::kBrickVoxels; ++i) {
      // Frames whose window ended before the voxel are missing: there the weights differ.
      if (moved.weights[first + i] == 0 || moved.weights[first + i] != fixed.weights[other->second + i]) continue;
      ++compared;
      wrong += std::abs(moved.distances[first + i] - fixed.distances[other->second + i]) > 1e-3f;
    }
  }
  EXPECT_GT(compared, 8000);
  EXPECT_LT(wrong, compared / 200) << "of " << compared << ": pixels at edges may round either way";
}

TEST_P(MovingWindow, WhatItComesBackToIsTheSameToTheBit) {
  Volume volume = make(VolumePlacement::follow);
  fuse(&volume, 0);
  fuse(&volume, 1);
  const Map before = volume.extract_map();
  const std::size_t packed = volume.packed_bricks();
  ASSERT_LT(packed, before.bricks.size() / 2);
  const Mesh mesh = volume.extract_mesh({.min_weight = 1});
  volume.follow({pose(60)});  // nothing of the former window is left
  EXPECT_EQ(volume.packed_bricks(), before.bricks.size());
  EXPECT_EQ(
      backend().compact(volume.view().states(), volume.view().slots(),
                        DeviceArray<std::int32_t>(backend(), static_cast<std::size_t>(volume.view().slots())).data()),
      0);
  volume.follow({pose(1)});
  ASSERT_EQ(volume.packed_bricks(), packed);
  const Map after = volume.extract_map();
  const auto first_before = index_of(before), first_after = index_of(after);
  ASSERT_EQ(first_before.size(), first_after.size());
  for (const auto& [key, first] : first_before) {
    const std::size_t now = first_after.at(key);
    for (std::size_t i = 0; i < Map::kBrickVoxels; ++i) {
      ASSERT_EQ(before.distances[first + i], after.distances[now + i]);
      ASSERT_EQ(before.weights[first + i], after.weights[now + i]);
    }
  }
  const Mesh again = volume.extract_mesh({.min_weight = 1});
  EXPECT_EQ(again.positions.size(), mesh.positions.size());
  EXPECT_EQ(again.triangles.size(), mesh.triangles.size());
  ASSERT_FALSE(again.colors.empty());
}

// A path of 40 m has drifted by more than registration reaches: what was mapped before it must not be tracked against.
TEST_P(MovingWindow, APlaceIsMappedAnewAfterALongWay) {
  Volume volume = make(VolumePlacement::follow);
  fuse(&volume, 0);
  const Map first = volume.extract_map();
  double travelled = volume.follow({pose(60)});
  EXPECT_NEAR(travelled, 30, 2);
  travelled = volume.follow({pose(0), travelled});
  EXPECT_GT(travelled, kConsistentOver);
  EXPECT_EQ(volume.packed_bricks(), first.bricks.size()) << "all stay out";
  volume.integrate(test::to_plane(backend(), test::view_of(corridor(), camera_, pose(0)).depth), nullptr, camera_,
                   pose(0));
  volume.follow({pose(60), travelled});
  EXPECT_GT(volume.packed_bricks(), first.bricks.size()) << "both are kept";
  EXPECT_EQ(volume.extract_map().bricks.size(), first.bricks.size()) << "the place counts once";
}

TEST_P(MovingWindow, AVisitShowsWhatWasMappedThereAndLeavesNothingBehind) {
  Volume volume = make(VolumePlacement::follow);
  fuse(&volume, 0);
  const std::size_t bricks = volume.extract_map().bricks.size();
  const double travelled = volume.follow({pose(60)});
  ASSERT_EQ(volume.packed_bricks(), bricks);
  volume.visit({pose(0), 0});
  EXPECT_EQ(volume.packed_bricks(), 0u) << "all is in the window";
  volume.follow({pose(0), travelled});  // the camera came here by another way than back to that map
  EXPECT_EQ(volume.packed_bricks(), bricks);
  volume.visit({pose(60), travelled});
  volume.visit({pose(0), 0});
  volume.follow({pose(0), 0});  // the camera is where the visit was
  EXPECT_EQ(volume.packed_bricks(), 0u);
  volume.follow({pose(60), 0});
  volume.follow({pose(0), 5});
  EXPECT_EQ(volume.packed_bricks(), 0u) << "it is still the map of before";
}

TEST_P(MovingWindow, AVisitIsNoWayThatTheCameraHasGone) {
  Volume volume = make(VolumePlacement::follow);
  fuse(&volume, 0);
  const double travelled = volume.follow({pose(5), volume.follow({pose(1), 0})});
  ASSERT_GT(travelled, 0);
  volume.visit({pose(60), travelled});
  EXPECT_EQ(volume.follow({pose(5), travelled}), travelled);
  volume.visit({pose(60), travelled});
  EXPECT_EQ(volume.follow({pose(60), 3}), 3) << "recognised elsewhere";
  EXPECT_GT(volume.follow({pose(66), 3}), 3);
}

TEST_P(MovingWindow, PredictsWhatTheCameraSees) {
  Volume volume = walk(VolumePlacement::follow);
  for (const int step : {kSteps - 1, 2}) {  // there, and back where it came from
    volume.follow({pose(step)});
    DepthPyramid model = make_pyramid(camera_, 1, backend());
    volume.predict(pose(step), RaycastRange(), &model);
    const Image<float> predicted = download(backend(), model.front().depth);
    const Image<float> truth = test::view_of(corridor(), camera_, pose(step)).depth;
    std::vector<double> errors;
    for (std::size_t i = 0; i < truth.pixels.size(); ++i) {
      if (predicted.pixels[i] > 0) errors.push_back(std::abs(double{predicted.pixels[i]} - double{truth.pixels[i]}));
    }
    EXPECT_GT(errors.size(), truth.pixels.size() / 4) << step << ": the window ends 1.6 m away";
    EXPECT_LT(test::quantile(errors, 0.5), 0.3 * kVoxel) << step;
  }
}

TEST_P(MovingWindow, ItsMeshIsOneSurfaceWithoutSeams) {
  const MeshParameters parameters{.min_weight = 1};
  const Mesh moved = walk(VolumePlacement::follow).extract_mesh(parameters);
  const Mesh fixed = walk(VolumePlacement::given).extract_mesh(parameters);
  ASSERT_GT(moved.triangles.size(), 5000u);
  std::vector<double> errors;
  for (const Mesh::Float3& p : moved.positions) errors.push_back(std::abs(corridor().distance({p.x, p.y, p.z})));
  EXPECT_LT(test::quantile(errors, 0.5), 0.15 * kVoxel);
  ASSERT_EQ(moved.colors.size(), moved.positions.size());
  // A seam would have the vertices of a brick's face twice.
  EXPECT_LT(doubled_vertices(moved), 5);
  EXPECT_LT(doubled_vertices(fixed), 5);
  EXPECT_GT(facing_free_space(fixed), 0.85);
  EXPECT_GT(facing_free_space(moved), facing_free_space(fixed) - 0.03);
}

TEST_P(MovingWindow, OtherPlacementsStay) {
  Volume volume(parameters(VolumePlacement::front, kSide), camera_, backend(), false);
  volume.place({kWorldFromVolume, kSide});
  volume.follow({pose(60)});
  EXPECT_EQ(volume.world_from_window().translation(), kWorldFromVolume.translation());
}

TEST_P(MovingWindow, PlacingItAgainForgetsWhatWasPacked) {
  Volume volume = walk(VolumePlacement::follow);
  ASSERT_GT(volume.packed_bricks(), 0u);
  volume.place({kWorldFromVolume, kSide});
  EXPECT_EQ(volume.packed_bricks(), 0u);
  EXPECT_TRUE(volume.extract_map().bricks.empty());
  volume.follow({pose(0)});
  fuse(&volume, 0);
  Volume fresh = make(VolumePlacement::follow);
  fuse(&fresh, 0);
  EXPECT_EQ(volume.extract_map().distances, fresh.extract_map().distances);
}

PLUMBLINE_ON_EVERY_LANE_TYPE(MovingWindow);

// ---- packed bricks --------------------------------------------------------------------------------------------------

BrickWords some_brick(unsigned seed) {
  std::mt19937 random(seed);
  BrickWords brick;
  brick.state = kernels::kBrickSolid;
  for (std::int32_t& word : brick.voxels) word = static_cast<std::int32_t>(random());
  for (std::int32_t& word : brick.colors) word = static_cast<std::int32_t>(random() & 0x7F7F7F7F);
  return brick;
}

TEST(PackedBricks, GivesBackWhatItWasGiven) {
  PackedBricks packed(true);
  const BrickWords noise = some_brick(1);  // does not compress at all
  BrickWords wall;
  wall.state = kernels::kBrickFree;
  for (std::size_t i = 0; i < wall.voxels.size(); ++i)
    wall.voxels[i] = static_cast<std::int32_t>(5 << 16 | 100 * (i >> 6));
  packed.keep({-3, 2, 1}, 0, noise.state, noise.voxels.data(), noise.colors.data());
  const std::size_t bytes_of_noise = packed.bytes();
  packed.keep({7, 0, 0}, 0, wall.state, wall.voxels.data(), wall.colors.data());
  EXPECT_LT(packed.bytes() - bytes_of_noise, sizeof(wall.voxels) / 5);
  EXPECT_EQ(packed.unpack({-3, 2, 1}, 0).voxels, noise.voxels);
  EXPECT_EQ(packed.unpack({-3, 2, 1}, 0).colors, noise.colors);
  EXPECT_EQ(packed.unpack({7, 0, 0}, 0).voxels, wall.voxels);
  EXPECT_EQ(packed.unpack({7, 0, 0}, 0).state, kernels::kBrickFree);
}

TEST(PackedBricks, KeepsOneBrickAPositionOfOneMap) {
  PackedBricks packed(false);
  const BrickWords first = some_brick(1), second = some_brick(2);
  packed.keep({1, 1, 1}, 2.5, first.state, first.voxels.data(), nullptr);
  const std::size_t bytes = packed.bytes();
  packed.keep({1, 1, 1}, 2.5, second.state, second.voxels.data(), nullptr);
  EXPECT_EQ(packed.size(), 1u);
  EXPECT_EQ(packed.bytes(), bytes);
  EXPECT_EQ(packed.unpack({1, 1, 1}, 2.5).voxels, second.voxels);
  EXPECT_EQ(packed.unpack({1, 1, 1}, 2.5).colors, BrickWords().colors);
  packed.remove({1, 1, 1}, 2.5);
  EXPECT_TRUE(packed.empty());
  EXPECT_EQ(packed.bytes(), 0u);
}

TEST(PackedBricks, TellsMapsOfOnePlaceApart) {
  PackedBricks packed(false);
  const BrickWords first = some_brick(1), second = some_brick(2), third = some_brick(3);
  packed.keep({1, 1, 1}, 40, third.state, third.voxels.data(), nullptr);
  packed.keep({1, 1, 1}, 2, first.state, first.voxels.data(), nullptr);
  packed.keep({1, 1, 1}, 20, second.state, second.voxels.data(), nullptr);
  EXPECT_EQ(packed.size(), 3u);
  EXPECT_EQ(packed.positions().size(), 1u);
  EXPECT_EQ(packed.nearest({1, 1, 1}, 0), 2);
  EXPECT_EQ(packed.nearest({1, 1, 1}, 12), 20);
  EXPECT_EQ(packed.nearest({1, 1, 1}, 99), 40);
  EXPECT_EQ(packed.unpack({1, 1, 1}, 20).voxels, second.voxels);
  EXPECT_EQ(packed.unpack_latest({1, 1, 1}).voxels, third.voxels);
  packed.remove({1, 1, 1}, 40);
  EXPECT_EQ(packed.unpack_latest({1, 1, 1}).voxels, second.voxels);
  EXPECT_EQ(packed.size(), 2u);
}

TEST(PackedBricks, FindsThoseInACube) {
  PackedBricks packed(false);
  const BrickWords brick = some_brick(3);
  for (const kernels::VoxelPosition& p :
       {kernels::VoxelPosition{-1, 0, 0}, {0, 0, 0}, {3, 3, 3}, {4, 0, 0}, {0, -1, 2}})
    packed.keep(p, 0, brick.state, brick.voxels.data(), nullptr);
  const auto inside = packed.positions_in({0, 0, 0}, 4);
  ASSERT_EQ(inside.size(), 2u);
  EXPECT_EQ(inside[0].x, 0);
  EXPECT_EQ(inside[1].z, 3);
  EXPECT_EQ(packed.positions().size(), 5u);
}

}  // namespace
}  // namespace plumbline
