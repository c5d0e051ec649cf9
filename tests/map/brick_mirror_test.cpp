// A copy of the map, meshed block by block, is the map's own mesh.
#include "map/brick_mirror.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "backend/backend.h"
#include "map/volume.h"
#include "plumbline/config.h"
#include "plumbline/image.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "sim/analytic_scene.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

constexpr int kMinWeight = 2;

using Point = std::array<long, 3>;  ///< in hundredths of a millimetre

/// Middles of the triangles, sorted.
std::vector<Point> middles(const Mesh& mesh) {
  std::vector<Point> points;
  for (const Mesh::Triangle& t : mesh.triangles) {
    const auto &a = mesh.positions[t.a], &b = mesh.positions[t.b], &c = mesh.positions[t.c];
    const auto middle = [](float x, float y, float z) { return std::lround(1e5 * (double{x} + y + z) / 3); };
    points.push_back({middle(a.x, b.x, c.x), middle(a.y, b.y, c.y), middle(a.z, b.z, c.z)});
  }
  std::sort(points.begin(), points.end());
  return points;
}

class AMirror : public testing::Test {
 protected:
  AMirror() : volume_(parameters(), camera_, *backend_, true) {
    volume_.place({SE3(Eigen::Quaterniond(0.8, 0, 0.6, 0), {1, 2, 3}), 1});
    for (int i = 0; i < 3; ++i) fuse(0.02 * i);
  }
  static VolumeParameters parameters() {
    VolumeParameters parameters = preset("kinectfusion").volume;
    parameters.resolution = 96;
    parameters.side = 1;
    parameters.truncation = 0.04;
    return parameters;
  }
  /// A sphere in the volume's middle.
  void fuse(double shift) {
    const sim::AnalyticScene scene{{sim::sphere({0.5, 0.5, 0.5}, 0.3)}};
    const SE3 volume_from_camera = sim::look_at({-0.4 + shift, 0.2, 0.9}, {0.5, 0.5, 0.5});
    const Image<float> depth = test::view_of(scene, camera_, volume_from_camera).depth;
    const Image<std::int32_t> color = filled(0x00804020);
    const Plane<std::int32_t> colors = test::to_plane(*backend_, color);
    volume_.integrate(test::to_plane(*backend_, depth), &colors, camera_,
                      volume_.world_from_volume() * volume_from_camera);
  }
  Image<std::int32_t> filled(std::int32_t value) const {
    Image<std::int32_t> image(camera_.width, camera_.height);
    std::fill(image.pixels.begin(), image.pixels.end(), value);
    return image;
  }

  std::shared_ptr<Backend> backend_ = make_backend("cpu", 1);
  Pinhole camera_ = test::pinhole(160, 120);
  Volume volume_;
};

TEST_F(AMirror, HasTheSurfaceOfTheMap) {
  BrickMirror mirror(10'000);
  Mesh all;
  for (const auto& [block, is_new] : mirror.update(volume_.copy_bricks(volume_.bricks_with_surface()))) {
    const BlockSurface surface = mirror.surface(block);
    ASSERT_EQ(surface.seen.size(), surface.mesh.positions.size());
    ASSERT_EQ(surface.mesh.normals.size(), surface.mesh.positions.size());
    ASSERT_EQ(surface.mesh.colors.size(), surface.mesh.positions.size());
    for (const double weight : surface.seen) EXPECT_TRUE(weight >= 0 && weight <= 3) << weight;
    for (const Mesh::Float3& n : surface.mesh.normals) EXPECT_NEAR(std::hypot(n.x, n.y, n.z), 1, 1e-4);
    const auto first = static_cast<std::uint32_t>(all.positions.size());
    all.positions.insert(all.positions.end(), surface.mesh.positions.begin(), surface.mesh.positions.end());
    for (const Mesh::Triangle& t : surface.mesh.triangles)
      all.triangles.push_back({t.a + first, t.b + first, t.c + first});
  }
  MeshParameters options;
  options.min_weight = kMinWeight;
  const std::vector<Point> expected = middles(volume_.extract_mesh(options)), found = middles(all);
  ASSERT_GT(expected.size(), 1000U);
  ASSERT_EQ(found.size(), expected.size());
  long worst = 0;
  for (std::size_t i = 0; i < found.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)  // sorting may swap equals within rounding: x alone is compared strictly
      if (k == 0) worst = std::max(worst, std::labs(found[i][k] - expected[i][k]));
  EXPECT_LE(worst, 2);
}

TEST_F(AMirror, TakesPartsAndTellsWhatTheyReach) {
  const std::vector<BrickKey> bricks = volume_.bricks_with_surface();
  BrickMirror whole(10'000), parts(10'000);
  whole.update(volume_.copy_bricks(bricks));
  std::vector<MapBlock> reached;
  for (const BrickKey brick : bricks)
    for (const auto& [block, is_new] : parts.update(volume_.copy_bricks({brick}))) reached.push_back(block);
  std::sort(reached.begin(), reached.end());
  reached.erase(std::unique(reached.begin(), reached.end()), reached.end());
  std::size_t triangles = 0;
  for (const MapBlock& block : reached) {
    EXPECT_EQ(middles(parts.surface(block).mesh), middles(whole.surface(block).mesh));
    triangles += whole.surface(block).mesh.triangles.size();
  }
  EXPECT_GT(triangles, 1000U);
  EXPECT_TRUE(whole.surface({50, 50, 50}).mesh.triangles.empty());
}

/// Of the surface that faces the camera, how well it was seen from so far in front of the sphere's middle.
double seen_from(const Volume& volume, const Pinhole& camera, const Eigen::Vector3d& eye,
                 const Eigen::Vector3d& facing) {
  BrickMirror mirror(10'000);
  const SE3 world_from_camera = volume.world_from_volume() * sim::look_at(eye, {0.5, 0.5, 0.5});
  const Eigen::Vector3d normal = volume.world_from_volume().rotation() * facing.normalized();
  double best = 0;
  for (const auto& [block, is_new] :
       mirror.update(volume.copy_bricks(volume.bricks_with_surface()), {camera, {world_from_camera}})) {
    const BlockSurface surface = mirror.surface(block);
    for (std::size_t i = 0; i < surface.seen.size(); ++i) {
      const Mesh::Float3& n = surface.mesh.normals[i];
      if (normal.dot(Eigen::Vector3d(n.x, n.y, n.z)) > 0.99) best = std::max(best, surface.seen[i]);
    }
  }
  return best;
}

TEST_F(AMirror, KnowsHowWellASurfaceWasSeen) {
  const Eigen::Vector3d middle(0.5, 0.5, 0.5), before = Eigen::Vector3d(-0.9, -0.3, 0.4).normalized();
  const Eigen::Vector3d near_eye = middle + 1.2 * before, far_eye = middle + 2.3 * before;
  const double near_by = seen_from(volume_, camera_, near_eye, before);
  EXPECT_NEAR(near_by, 3, 0.2) << "three frames, from 0.9 m";
  EXPECT_NEAR(seen_from(volume_, camera_, far_eye, before), 3 / 4.0, 0.1) << "from 2 m";
  const Eigen::Vector3d aside = before.unitOrthogonal();
  const double oblique = seen_from(volume_, camera_, near_eye, before + aside);
  EXPECT_TRUE(oblique > 0.4 * near_by && oblique < 0.8 * near_by) << oblique << " of " << near_by;
}

TEST_F(AMirror, IsBounded) {
  const std::vector<BrickKey> bricks = volume_.bricks_with_surface();
  BrickMirror mirror(bricks.size() / 2);
  mirror.update(volume_.copy_bricks(bricks));
  EXPECT_TRUE(mirror.is_full());
  mirror.clear();
  EXPECT_FALSE(mirror.is_full());
}

}  // namespace
}  // namespace plumbline
