// Fusion into the volume: against closed forms where a wall is seen straight on, and against brute force over every
// voxel from cameras anywhere.
#include <cstring>

#include "map/reference_volume.h"
#include "map/volume.h"
#include "plumbline/image.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "support/lane_types.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

using test::voxel_at;

constexpr int kResolution = 64;
constexpr double kSide = 1.0, kVoxel = kSide / kResolution, kTruncation = 0.05;

VolumeParameters volume_parameters() {
  VolumeParameters parameters = preset("kinectfusion").volume;
  parameters.resolution = kResolution;
  parameters.side = kSide;
  parameters.truncation = kTruncation;
  return parameters;
}

/// The volume before the camera: the camera's axis goes through its middle, its front face is `offset` metres ahead.
SE3 camera_from_volume(double offset = 0.3) {
  return {Eigen::Matrix3d::Identity(), {-0.5 * kSide, -0.5 * kSide, offset}};
}

class Fusion : public test::LaneTest {
 protected:
  /// The camera is the world's frame.
  Volume make_volume(const SE3& world_from_volume = camera_from_volume(), bool color = false,
                     const VolumeParameters& parameters = volume_parameters()) const {
    Volume volume(parameters, camera_, backend(), color);
    volume.place({world_from_volume, parameters.side});
    return volume;
  }

  void fuse(Volume* volume, const Image<float>& depth, const SE3& world_from_camera = {}) const {
    volume->integrate(test::to_plane(backend(), depth), nullptr, camera_, world_from_camera);
  }

  Image<float> wall(float z) const {
    Image<float> depth(camera_.width, camera_.height);
    std::fill(depth.pixels.begin(), depth.pixels.end(), z);
    return depth;
  }

  Pinhole camera_ = test::pinhole(160, 120);
};

std::vector<std::int32_t> all_words(const kernels::BrickMap& view) {
  return {view.voxels_of(0), view.voxels_of(view.slots())};
}

bool is_blank(const kernels::BrickMap& view) {
  const std::vector<std::int32_t> words = all_words(view);
  return std::all_of(words.begin(), words.end(), [](std::int32_t word) { return word == 0; });
}

/// Depth of a voxel's centre in the frame of a camera placed by `camera_from_volume(offset)`.
double depth_of(int z, double offset = 0.3) { return offset + (z + 0.5) * kVoxel; }

bool in_view(const Pinhole& camera, int x, int y, int z, double offset = 0.3) {
  const Eigen::Vector3d p = camera_from_volume(offset) * (Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5) * kVoxel);
  const double u = p.x() / p.z() * double{camera.fx} + double{camera.cx};
  const double v = p.y() / p.z() * double{camera.fy} + double{camera.cy};
  return u > -0.49 && v > -0.49 && u < camera.width - 0.51 && v < camera.height - 0.51;
}

template <class Visit>
void for_each_voxel(const Visit& visit) {
  for (int z = 0; z < kResolution; ++z) {
    for (int y = 0; y < kResolution; ++y) {
      for (int x = 0; x < kResolution; ++x) visit(x, y, z);
    }
  }
}

// ---- closed forms ---------------------------------------------------------------------------------------------------

TEST_P(Fusion, AWallGivesItsDistance) {
  constexpr double kWall = 0.8;
  Volume volume = make_volume();
  fuse(&volume, wall(static_cast<float>(kWall)));
  int checked = 0;
  for_each_voxel([&](int x, int y, int z) {
    const kernels::Voxel<float> voxel = voxel_at(volume.view(), x, y, z);
    const double distance = kWall - depth_of(z);
    if (distance < -kTruncation - 1e-6) {
      ASSERT_EQ(voxel.weight, 0) << "far behind the surface nothing is known, at " << x << ", " << y << ", " << z;
    } else if (in_view(camera_, x, y, z) && std::abs(distance) < kTruncation - 1e-6) {
      ASSERT_EQ(voxel.weight, 1) << x << ", " << y << ", " << z;
      ASSERT_NEAR(double{voxel.distance}, distance / kTruncation, 5e-5);
      ++checked;
    } else if (voxel.weight > 0) {
      ASSERT_NEAR(double{voxel.distance}, std::min(1.0, distance / kTruncation), 5e-5);
    }
  });
  EXPECT_GT(checked, 10000);
}

TEST_P(Fusion, FreeSpaceAloneLeavesNoTrace) {
  constexpr double kWall = 1.1;
  Volume volume = make_volume();
  fuse(&volume, wall(static_cast<float>(kWall)));
  EXPECT_GT(test::occupied_bricks(volume.view()), 0);
  for_each_voxel([&](int x, int y, int z) {
    const double nearest_of_brick = kWall - depth_of(z / 8 * 8 + 7);
    if (nearest_of_brick < kTruncation + 1e-6) return;
    ASSERT_EQ(volume.view().state(volume.view().find({x, y, z}).brick), 0);
    ASSERT_EQ(voxel_at(volume.view(), x, y, z).weight, 0);
  });
}

TEST_P(Fusion, FreeSpaceCarvesWhatWasThere) {
  Volume volume = make_volume();
  fuse(&volume, wall(0.7f));
  const std::vector<std::int32_t> before = all_words(volume.view());
  constexpr int kFrames = 3;
  for (int i = 0; i < kFrames; ++i) fuse(&volume, wall(1.2f));
  int carved = 0;
  for_each_voxel([&](int x, int y, int z) {
    const std::int32_t old = before[static_cast<std::size_t>(&volume.view().voxel(volume.view().find({x, y, z})) -
                                                             volume.view().voxels_of(0))];
    const kernels::Voxel<float> first = kernels::unpack<float>(old);
    if (first.weight == 0 || !in_view(camera_, x, y, z)) return;
    const kernels::Voxel<float> now = voxel_at(volume.view(), x, y, z);
    ASSERT_EQ(now.weight, 1 + kFrames);
    ASSERT_NEAR(now.distance, (first.distance + kFrames) / (1 + kFrames), 1e-4f);
    carved += first.distance < 0;
  });
  EXPECT_GT(carved, 3000) << "voxels behind the first wall that are free now";
}

TEST_P(Fusion, WeightsStopAtTheirCap) {
  VolumeParameters parameters = volume_parameters();
  parameters.max_weight = 3;
  Volume volume = make_volume(camera_from_volume(), false, parameters);
  for (int i = 0; i < 5; ++i) fuse(&volume, wall(0.8f));
  int capped = 0;
  for_each_voxel([&](int x, int y, int z) {
    const kernels::Voxel<float> voxel = voxel_at(volume.view(), x, y, z);
    ASSERT_LE(voxel.weight, 3);
    if (voxel.weight < 3) return;
    ++capped;
    ASSERT_NEAR(double{voxel.distance}, std::min(1.0, (0.8 - depth_of(z)) / kTruncation), 1e-4);
  });
  EXPECT_GT(capped, 10000);
  // Past the cap the average forgets: a new value counts one in four.
  fuse(&volume, wall(0.81f));
  const int middle = kResolution / 2, z = static_cast<int>((0.8 - 0.3) / kVoxel);
  const double old = (0.8 - depth_of(z)) / kTruncation, now = (0.81 - depth_of(z)) / kTruncation;
  EXPECT_NEAR(double{voxel_at(volume.view(), middle, middle, z).distance}, (3 * old + now) / 4, 1e-4);
}

TEST_P(Fusion, WeightsUseAllSixteenBits) {
  VolumeParameters parameters = volume_parameters();
  parameters.max_weight = 65535;
  Volume volume = make_volume(camera_from_volume(), false, parameters);
  fuse(&volume, wall(0.8f));
  const std::vector<std::int32_t> first = all_words(volume.view());
  const kernels::BrickMap& view = volume.view();
  for (std::size_t i = 0; i < first.size(); ++i) {
    if (first[i] == 0) continue;
    kernels::Voxel<float> voxel = kernels::unpack<float>(first[i]);
    voxel.weight = 65534;
    view.voxels_of(0)[i] = kernels::pack<float>(voxel);
  }
  for (int i = 0; i < 3; ++i) fuse(&volume, wall(0.8f));
  int checked = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const kernels::Voxel<float> voxel = kernels::unpack<float>(view.voxels_of(0)[i]);
    ASSERT_EQ(voxel.weight, first[i] == 0 ? 0 : 65535);
    ASSERT_NEAR(voxel.distance, kernels::unpack<float>(first[i]).distance, 1e-4f);
    checked += voxel.weight > 0 && voxel.distance < 0;
  }
  EXPECT_GT(checked, 3000) << "of negative distance";
}

TEST_P(Fusion, ACameraInsideSeesOnlyWhatIsAhead) {
  constexpr double kOffset = -0.5;  // in the middle of the volume
  Volume volume = make_volume(camera_from_volume(kOffset));
  fuse(&volume, wall(0.3f));
  int seen = 0;
  for_each_voxel([&](int x, int y, int z) {
    const kernels::Voxel<float> voxel = voxel_at(volume.view(), x, y, z);
    const double distance = 0.3 - depth_of(z, kOffset);
    if (depth_of(z, kOffset) <= 0) {
      ASSERT_EQ(voxel.weight, 0) << "behind the camera";
    } else if (in_view(camera_, x, y, z, kOffset) && std::abs(distance) < kTruncation - 1e-6) {
      ASSERT_EQ(voxel.weight, 1);
      ASSERT_NEAR(double{voxel.distance}, distance / kTruncation, 5e-5);
      ++seen;
    }
  });
  EXPECT_GT(seen, 1000);
}

TEST_P(Fusion, ASceneBeyondTheVolumeWritesNothing) {
  Volume volume = make_volume();
  fuse(&volume, wall(3.0f));
  EXPECT_EQ(test::occupied_bricks(volume.view()), 0);
  EXPECT_TRUE(is_blank(volume.view()));
  // Nor one in front of it.
  fuse(&volume, wall(0.1f));
  EXPECT_EQ(test::occupied_bricks(volume.view()), 0);
  EXPECT_TRUE(is_blank(volume.view()));
}

TEST_P(Fusion, ACameraThatLooksAwayWritesNothing) {
  Volume volume = make_volume();
  fuse(&volume, wall(0.8f), SE3(so3::exp({0, std::numbers::pi, 0}), Eigen::Vector3d::Zero()));
  EXPECT_EQ(volume.bricks_updated(), 0);
  EXPECT_TRUE(is_blank(volume.view()));
}

TEST_P(Fusion, AnEmptyImageChangesNothing) {
  Volume volume = make_volume();
  fuse(&volume, wall(0));
  EXPECT_EQ(volume.bricks_updated(), 0);
  EXPECT_TRUE(is_blank(volume.view()));
  fuse(&volume, wall(0.8f));
  const std::vector<std::int32_t> before = all_words(volume.view());
  fuse(&volume, wall(0));
  EXPECT_EQ(volume.bricks_updated(), 0);
  EXPECT_EQ(all_words(volume.view()), before);
}

TEST_P(Fusion, ASingleReadingIsNotOverlooked) {
  // On the pixel that a voxel's centre projects to.
  for (const auto& [x, y, z] : {std::array{40, 37, 32}, {7, 8, 63}, {33, 31, 0}}) {
    const Eigen::Vector3d p = camera_from_volume() * (Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5) * kVoxel);
    const double u = p.x() / p.z() * double{camera_.fx} + double{camera_.cx};
    const double v = p.y() / p.z() * double{camera_.fy} + double{camera_.cy};
    Image<float> depth = wall(0);
    depth.at(static_cast<int>(std::lround(u)), static_cast<int>(std::lround(v))) = static_cast<float>(p.z() + 0.01);
    Volume volume = make_volume();
    fuse(&volume, depth);
    EXPECT_EQ(voxel_at(volume.view(), x, y, z).weight, 1);
    EXPECT_NEAR(double{voxel_at(volume.view(), x, y, z).distance}, 0.01 / kTruncation, 5e-5);
  }
}

// ---- brute force ----------------------------------------------------------------------------------------------------

/// A sphere, a box and a slanted plane in a volume that lies askew in the world.
struct Cluttered {
  SE3 world_from_volume = test::Random(11).motion(1.0, 0.7);
  sim::AnalyticScene scene;

  Cluttered() {
    const auto at = [&](double x, double y, double z) {
      return Eigen::Vector3d(world_from_volume * Eigen::Vector3d(x, y, z));
    };
    scene.primitives = {
        sim::sphere(at(0.35, 0.4, 0.55), 0.18),
        sim::box(world_from_volume * SE3(so3::exp({0.3, 0.5, -0.2}), {0.7, 0.65, 0.4}), {0.1, 0.16, 0.12}),
        sim::plane(at(0.5, 0.5, 0.9), world_from_volume.rotation() * Eigen::Vector3d(0.2, -0.1, -1)),
    };
  }

  /// Cameras around the volume, in it, at its faces and corners, some of them looking away.
  SE3 world_from_camera(int i) const {
    test::Random random(static_cast<unsigned>(100 + i));
    const Eigen::Vector3d centre = Eigen::Vector3d::Constant(0.5);
    Eigen::Vector3d eye = centre + random.direction() * random.uniform(1.0, 2.0);
    Eigen::Vector3d target = centre + random.direction() * 0.3;
    switch (i % 6) {
      case 1:  // inside
        eye = {random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
        target = eye + random.direction();
        break;
      case 2:  // along a face
        eye = {random.uniform(-0.4, -0.1), random.uniform(0, 1), random.uniform(-0.02, 0.02)};
        target = eye + Eigen::Vector3d(1, random.uniform(-0.1, 0.1), random.uniform(-0.02, 0.02));
        break;
      case 3:  // away from it
        target = eye + (eye - centre);
        break;
      case 4:  // at a corner
        eye = Eigen::Vector3d(random.integer(0, 1), random.integer(0, 1), random.integer(0, 1)) +
              random.direction() * 0.02;
        target = centre;
        break;
      default:
        break;
    }
    return world_from_volume * sim::look_at(eye, target, random.direction());
  }

  /// Sizes, principal points and the direction of y differ.
  static Pinhole camera(int i) {
    Pinhole k = i % 2 == 0 ? test::pinhole(160, 120) : test::pinhole(97, 73);
    if (i % 3 == 0) k.fy = -k.fy;
    if (i % 4 == 1) k.cx += 30;
    if (i % 5 == 2) k.fx *= 0.4f;
    return k;
  }
};

/// Two frames into an empty volume, by brute force.
struct ReferenceCase {
  Pinhole camera;
  std::array<SE3, 2> world_from_camera;
  std::array<Image<float>, 2> depth;
  test::ReferenceVolume reference;
};

constexpr int kCases = 60;

const std::vector<ReferenceCase>& reference_cases() {
  static const std::vector<ReferenceCase> cases = [] {
    const Cluttered clutter;
    std::vector<ReferenceCase> result;
    for (int i = 0; i < kCases; ++i) {
      ReferenceCase c{Cluttered::camera(i),
                      {clutter.world_from_camera(i), clutter.world_from_camera(i + 6 * kCases + 1)},
                      {},
                      {kResolution / 8, kSide, kTruncation, 128}};
      for (std::size_t k = 0; k < 2; ++k) {
        c.depth[k] = test::view_of(clutter.scene, c.camera, c.world_from_camera[k]).depth;
        c.reference.integrate(c.depth[k], c.camera, c.world_from_camera[k].inverse() * clutter.world_from_volume);
      }
      result.push_back(std::move(c));
    }
    return result;
  }();
  return cases;
}

TEST_P(Fusion, MatchesBruteForceFromAnywhere) {
  test::ReferenceVolume::Comparison total;
  int occupied = 0, cases_with_surface = 0;
  for (int i = 0; i < kCases; ++i) {
    const ReferenceCase& c = reference_cases()[static_cast<std::size_t>(i)];
    Volume volume(volume_parameters(), c.camera, backend(), false);
    volume.place({Cluttered().world_from_volume, kSide});
    for (std::size_t k = 0; k < 2; ++k)
      volume.integrate(test::to_plane(backend(), c.depth[k]), nullptr, c.camera, c.world_from_camera[k]);
    const test::ReferenceVolume::Comparison comparison = c.reference.compare(volume.view());
    EXPECT_EQ(comparison.wrong, 0) << "case " << i;
    total.compared += comparison.compared;
    total.seen += comparison.seen;
    total.left_out += comparison.left_out;
    occupied += c.reference.occupied();
    cases_with_surface += c.reference.occupied() > 0;
  }
  EXPECT_LT(total.left_out, total.compared / 50);
  EXPECT_GT(total.seen, 100000);
  EXPECT_GT(occupied, 2000);
  EXPECT_GT(cases_with_surface, kCases / 2);
}

TEST_P(Fusion, ManyPosesAgreeWithBruteForce) {
  const Cluttered clutter;
  Volume volume = make_volume(clutter.world_from_volume);
  test::ReferenceVolume reference(kResolution / 8, kSide, kTruncation, 128);
  for (int i = 0; i < 8; ++i) {
    const SE3 pose = clutter.world_from_camera(6 * i);
    const Image<float> depth = test::view_of(clutter.scene, camera_, pose).depth;
    fuse(&volume, depth, pose);
    reference.integrate(depth, camera_, pose.inverse() * clutter.world_from_volume);
  }
  const test::ReferenceVolume::Comparison comparison = reference.compare(volume.view());
  EXPECT_EQ(comparison.wrong, 0);
  EXPECT_GT(comparison.seen, 20000);
  EXPECT_LT(comparison.left_out, comparison.compared / 10);
}

// ---- colour ---------------------------------------------------------------------------------------------------------

class FusionColor : public Fusion {
 protected:
  void fuse(Volume* volume, float z, int red, int green, int blue) const {
    Image<std::int32_t> colors(camera_.width, camera_.height);
    std::fill(colors.pixels.begin(), colors.pixels.end(), red | green << 8 | blue << 16);
    const Plane<std::int32_t> plane = test::to_plane(backend(), colors);
    volume->integrate(test::to_plane(backend(), wall(z)), &plane, camera_, SE3());
  }

  struct Color {
    int red, green, blue, weight;
    bool operator==(const Color&) const = default;
  };
  static Color color_at(const Volume& volume, int x, int y, int z) {
    const auto word = static_cast<std::uint32_t>(volume.view().color(volume.view().find({x, y, z})));
    return {static_cast<int>(word & 255), static_cast<int>(word >> 8 & 255), static_cast<int>(word >> 16 & 255),
            static_cast<int>(word >> 24)};
  }
  static constexpr int kMiddle = kResolution / 2;
  static constexpr int kOnWall = 32;  // its voxels lie 0.8 m ahead
};

TEST_P(FusionColor, IsTheAverage) {
  Volume volume = make_volume(camera_from_volume(), true);
  fuse(&volume, 0.8f, 200, 100, 255);
  EXPECT_EQ(color_at(volume, kMiddle, kMiddle, kOnWall), (Color{200, 100, 255, 1}));
  fuse(&volume, 0.8f, 100, 200, 0);
  EXPECT_EQ(color_at(volume, kMiddle, kMiddle, kOnWall), (Color{150, 150, 128, 2})) << "rounded to the nearest";
  fuse(&volume, 0.8f, 0, 0, 0);
  EXPECT_EQ(color_at(volume, kMiddle, kMiddle, kOnWall), (Color{100, 100, 85, 3}));
}

TEST_P(FusionColor, StaysNearTheSurface) {
  Volume volume = make_volume(camera_from_volume(), true);
  fuse(&volume, 0.8f, 200, 100, 50);
  int coloured = 0;
  for_each_voxel([&](int x, int y, int z) {
    const bool near = std::abs(0.8 - depth_of(z)) < kTruncation - 1e-6 && in_view(camera_, x, y, z);
    const Color color = color_at(volume, x, y, z);
    if (near) {
      ASSERT_EQ(color, (Color{200, 100, 50, 1}));
      ++coloured;
    } else if (std::abs(0.8 - depth_of(z)) > kTruncation + 1e-6) {
      ASSERT_EQ(color, (Color{0, 0, 0, 0})) << x << ", " << y << ", " << z;
    }
  });
  EXPECT_GT(coloured, 10000);
}

TEST_P(FusionColor, KeepsMovingAfterManyFrames) {
  Volume volume = make_volume(camera_from_volume(), true);
  for (int i = 0; i < 60; ++i) fuse(&volume, 0.8f, 250, 10, 128);
  EXPECT_EQ(color_at(volume, kMiddle, kMiddle, kOnWall), (Color{250, 10, 128, 32})) << "the weight stops at 32";
  for (int i = 0; i < 200; ++i) fuse(&volume, 0.8f, 10, 250, 128);
  const Color color = color_at(volume, kMiddle, kMiddle, kOnWall);
  EXPECT_LT(color.red, 40) << "what is seen now wins in the end";
  EXPECT_GT(color.green, 220);
  EXPECT_EQ(color.blue, 128);
}

TEST_P(FusionColor, AFrameWithoutColourKeepsIt) {
  Volume volume = make_volume(camera_from_volume(), true);
  fuse(&volume, 0.8f, 200, 100, 50);
  Fusion::fuse(&volume, wall(0.8f));
  EXPECT_EQ(color_at(volume, kMiddle, kMiddle, kOnWall), (Color{200, 100, 50, 1}));
  EXPECT_EQ(voxel_at(volume.view(), kMiddle, kMiddle, kOnWall).weight, 2);
}

// ---- other lane types, threads --------------------------------------------------------------------------------------

TEST_P(Fusion, AgreesWithPlainFloat) {
  const Cluttered clutter;
  const auto scalar = test::make_lanes("scalar");
  const auto fused_by = [&](const Backend& other) {
    Volume volume(volume_parameters(), camera_, other, false);
    volume.place({clutter.world_from_volume, kSide});
    for (int i = 0; i < 3; ++i) {
      const SE3 pose = clutter.world_from_camera(6 * i);
      volume.integrate(test::to_plane(other, test::view_of(clutter.scene, camera_, pose).depth), nullptr, camera_,
                       pose);
    }
    return all_words(volume.view());
  };
  const std::vector<std::int32_t> expected = fused_by(*scalar), actual = fused_by(backend());
  int seen = 0, differing = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const kernels::Voxel<float> a = kernels::unpack<float>(expected[i]), b = kernels::unpack<float>(actual[i]);
    seen += a.weight > 0;
    differing += a.weight != b.weight || std::abs(a.distance - b.distance) > 1e-3f;
  }
  EXPECT_GT(seen, 10000);
  EXPECT_LT(differing, seen / 200) << "voxels that project onto the border of two pixels";
}

PLUMBLINE_ON_EVERY_LANE_TYPE(Fusion);
PLUMBLINE_ON_EVERY_LANE_TYPE(FusionColor);

}  // namespace
}  // namespace plumbline
