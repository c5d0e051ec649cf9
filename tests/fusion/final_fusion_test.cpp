// The final fusion on analytic scenes, whose surface is known: error, closed surfaces, what is carved and voted out,
// and the same bits for any number of threads.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <utility>

#include "fusion/fine_map.h"
#include "fusion/free_memory.h"
#include "fusion/mesh_cleanup.h"
#include "map/mesh_of_bricks.h"
#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/frame.h"
#include "plumbline/fusion.h"
#include "plumbline/mesh.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "plumbline/sequence.h"
#include "plumbline/time.h"
#include "sim/analytic_scene.h"
#include "support/error_of.h"
#include "support/lane_types.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

using testing::HasSubstr;

SequenceInfo info_of(const Pinhole& camera, int frames) {
  SequenceInfo info;
  info.camera = camera;
  info.frames = info.color_frames = frames;
  return info;
}

std::vector<Nanoseconds> times(std::size_t count) {
  std::vector<Nanoseconds> result;
  for (std::size_t i = 0; i < count; ++i)
    result.push_back(static_cast<Nanoseconds>(i + 1) * kNanosecondsPerSecond / 30);
  return result;
}

/// Views of an analytic scene, which may be changed before they are read.
class Views : public Sequence {
 public:
  Views(const sim::AnalyticScene& scene, const Pinhole& camera, const std::vector<SE3>& poses)
      : Sequence(info_of(camera, static_cast<int>(poses.size())), times(poses.size())) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      frames.push_back(sim::render(scene, camera, poses[i], time(static_cast<int>(i))));
      frames.back().index = static_cast<int>(i);
      path.push_back({static_cast<int>(i), poses[i]});
    }
  }
  Frame read(int index) const override {
    if (index == damaged) throw Error("is damaged", "frame " + std::to_string(index), "");
    return frames[static_cast<std::size_t>(index)];
  }
  ImuRecording read_imu(std::vector<std::string>*) const override { return {}; }

  std::vector<Frame> frames;
  std::vector<FusionFrame> path;
  int damaged = -1;
};

/// From all around a point, above and below.
std::vector<SE3> all_around(const Eigen::Vector3d& target, double distance) {
  std::vector<SE3> poses;
  for (const double elevation : {-70.0, -35.0, 0.0, 35.0, 70.0})
    for (int i = 0; i < 12; ++i) {
      const double azimuth = radians(30.0 * i + elevation), up = radians(elevation);
      poses.push_back(sim::look_at(target + distance * Eigen::Vector3d(std::cos(up) * std::cos(azimuth),
                                                                       std::cos(up) * std::sin(azimuth), std::sin(up)),
                                   target));
    }
  return poses;
}

FusionOptions options_of(double detail) {
  FusionOptions options;
  options.detail = detail;
  options.threads = 1;
  options.memory = std::size_t{1} << 30;
  return options;
}

Mesh fused(const Sequence& sequence, const std::vector<FusionFrame>& path, const FusionOptions& options) {
  const auto result = fuse_frames(sequence, path, options);
  EXPECT_TRUE(result);
  return result ? result->mesh : Mesh();
}

/// Edges that do not have one triangle on either side, in opposite directions.
int open_edges(const Mesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const Mesh::Triangle& t : mesh.triangles)
    for (const auto& [a, b] : {std::pair{t.a, t.b}, {t.b, t.c}, {t.c, t.a}})
      edges[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1000;
  int open = 0;
  for (const auto& [edge, sides] : edges) open += sides != 1 - 1000;
  return open;
}

std::vector<double> errors_of(const Mesh& mesh, const sim::AnalyticScene& scene) {
  std::vector<double> errors;
  for (const Mesh::Float3& p : mesh.positions) errors.push_back(scene.distance({p.x, p.y, p.z}));
  return errors;
}

bool same_bits(const Mesh& a, const Mesh& b) {
  const auto same = [](const auto& x, const auto& y) {
    return x.size() == y.size() && (x.empty() || std::memcmp(x.data(), y.data(), x.size() * sizeof x[0]) == 0);
  };
  return same(a.positions, b.positions) && same(a.normals, b.normals) && same(a.colors, b.colors) &&
         same(a.triangles, b.triangles);
}

const Pinhole kCamera = test::pinhole(320, 240);
const Eigen::Vector3d kCentre(0.1, -0.2, 0.3);
constexpr double kRadius = 0.25;

sim::AnalyticScene ball() { return {{sim::sphere(kCentre, kRadius, {.first = {200, 100, 50}, .second = {}})}}; }

TEST(FinalFusion, ASphereIsClosedSmoothAndOfItsColor) {
  const Views views(ball(), kCamera, all_around(kCentre, 0.9));
  const Mesh mesh = fused(views, views.path, options_of(0.005));
  ASSERT_GT(mesh.triangles.size(), 10'000u);
  EXPECT_EQ(open_edges(mesh), 0);
  EXPECT_LT(test::quantile(errors_of(mesh, ball()), 0.5), 0.0006);
  EXPECT_LT(test::quantile(errors_of(mesh, ball()), 1.0), 0.004);
  std::vector<double> angles;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Eigen::Vector3d p(mesh.positions[i].x, mesh.positions[i].y, mesh.positions[i].z);
    const Eigen::Vector3d n(mesh.normals[i].x, mesh.normals[i].y, mesh.normals[i].z);
    angles.push_back(test::angle_between(n, p - kCentre));
    ASSERT_NEAR(mesh.colors[i].r, 200, 1);
    ASSERT_NEAR(mesh.colors[i].g, 100, 1);
    ASSERT_NEAR(mesh.colors[i].b, 50, 1);
  }
  EXPECT_LT(test::quantile(angles, 0.95), radians(6));
}

/// What lies within a distance of a point.
Mesh part_around(const Mesh& mesh, const Eigen::Vector3d& centre, double distance) {
  Mesh part = mesh;
  std::erase_if(part.triangles, [&](const Mesh::Triangle& t) {
    const Mesh::Float3& p = mesh.positions[t.a];
    return (Eigen::Vector3d(p.x, p.y, p.z) - centre).norm() > distance;
  });
  drop_unused_vertices(&part);
  return part;
}

TEST(FinalFusion, ABoxAcrossManyBricksHasNoCracks) {
  const SE3 pose(so3::exp(Eigen::Vector3d(0.3, -0.5, 0.2)), kCentre);
  const sim::AnalyticScene scene{{sim::box(pose, {0.2, 0.15, 0.1}), sim::sphere(kCentre, 2)}};  // in a round room
  const Views views(scene, kCamera, all_around(kCentre, 0.9));
  const Mesh mesh = part_around(fused(views, views.path, options_of(0.006)), kCentre, 0.5);
  ASSERT_GT(mesh.triangles.size(), 5000u);
  EXPECT_EQ(open_edges(mesh), 0);
  EXPECT_LT(test::quantile(errors_of(mesh, {{scene.primitives.front()}}), 0.5), 0.001);
}

TEST(FinalFusion, WhatIsSeenFromOneSideHasNoBack) {
  const sim::AnalyticScene board{{sim::box(SE3(Eigen::Matrix3d::Identity(), kCentre), {0.2, 0.2, 0.004})}};
  std::vector<SE3> poses;
  for (int i = 0; i < 12; ++i)
    poses.push_back(sim::look_at(kCentre + Eigen::Vector3d(0.5 * std::cos(i), 0.5 * std::sin(i), 0.8), kCentre));
  const Views views(board, kCamera, poses);
  const Mesh mesh = fused(views, views.path, options_of(0.005));
  ASSERT_GT(mesh.triangles.size(), 5000u);
  for (const Mesh::Float3& n : mesh.normals) EXPECT_GT(n.z, -0.2);
  EXPECT_LT(test::quantile(errors_of(mesh, board), 0.99), 0.006);
}

TEST(FinalFusion, HasTheSameBitsForAnyNumberOfThreads) {
  const Views views(ball(), kCamera, all_around(kCentre, 0.9));
  FusionOptions options = options_of(0.008);
  const Mesh one = fused(views, views.path, options);
  options.threads = 3;
  EXPECT_TRUE(same_bits(one, fused(views, views.path, options)));
}

TEST(FinalFusion, WhatOthersSeeThroughIsVotedOut) {
  const sim::AnalyticScene wall{{sim::plane({0, 0, 0}, {0, 0, 1})}};
  const std::vector<SE3> poses(20, sim::look_at({0.3, 0.2, 1.2}, {0, 0, 0}, Eigen::Vector3d::UnitY()));
  Views views(wall, kCamera, poses);
  sim::AnalyticScene passing = wall;
  passing.primitives.push_back(sim::sphere({0.1, 0, 0.5}, 0.12));
  for (int i = 4; i < 8; ++i) {
    views.frames[static_cast<std::size_t>(i)] =
        sim::render(passing, kCamera, poses.front(), views.frames[static_cast<std::size_t>(i)].time);
  }
  const Mesh mesh = fused(views, views.path, options_of(0.006));
  ASSERT_GT(mesh.positions.size(), 5000u);
  for (const Mesh::Float3& p : mesh.positions) EXPECT_LT(p.z, 0.05);
  // Alone, what passes by is there.
  const std::vector<FusionFrame> part(views.path.begin() + 4, views.path.begin() + 8);
  float highest = 0;
  for (const Mesh::Float3& p : fused(views, part, options_of(0.006)).positions) highest = std::max(highest, p.z);
  EXPECT_GT(highest, 0.5f);
}

TEST(FinalFusion, HolesStayHolesAndStrayReadingsVanish) {
  const sim::AnalyticScene wall{{sim::plane({0, 0, 0}, {0, 0, 1})}};
  Views views(wall, kCamera, std::vector<SE3>(10, sim::look_at({0, 0, 1}, {0, 0, 0}, Eigen::Vector3d::UnitY())));
  test::Random random(7);
  for (Frame& frame : views.frames) {
    for (int y = 80; y < 160; ++y)
      for (int x = 100; x < 200; ++x) frame.depth.at(x, y) = 0;
    for (int i = 0; i < 300; ++i)
      frame.depth.at(random.integer(0, 319), random.integer(0, 239)) =
          static_cast<std::uint16_t>(random.integer(2000, 4000));
  }
  const Mesh mesh = fused(views, views.path, options_of(0.006));
  ASSERT_GT(mesh.positions.size(), 5000u);
  for (const Mesh::Float3& p : mesh.positions) {
    EXPECT_LT(std::abs(p.z), 0.003);
    EXPECT_GT(std::max(std::abs(p.x) / 0.09f, std::abs(p.y) / 0.07f), 1.0f);
  }
}

TEST(FinalFusion, FarFromTheWorldsOriginIsAsGood) {
  // A kilometre away single precision has 0.06 mm; beyond what bricks are counted to, nothing is fused.
  const Eigen::Vector3d far = kCentre + Eigen::Vector3d(-900, 400, 250);
  const sim::AnalyticScene scene{{sim::sphere(far, kRadius)}};
  const Views views(scene, kCamera, all_around(far, 0.9));
  const Mesh mesh = fused(views, views.path, options_of(0.006));
  EXPECT_EQ(open_edges(mesh), 0);
  EXPECT_LT(test::quantile(errors_of(mesh, scene), 0.5), 0.001);
  std::vector<FusionFrame> lost = views.path;
  for (FusionFrame& frame : lost) frame.world_from_camera = SE3(Eigen::Matrix3d::Identity(), {1e9, 0, 0});
  EXPECT_FALSE(fuse_frames(views, lost, options_of(0.006)));
}

TEST(FinalFusion, TwoScansAKilometreApartTakeTheMemoryOfTwo) {
  const Views views(ball(), kCamera, all_around(kCentre, 0.9));
  const auto one = fuse_frames(views, views.path, options_of(0.008));
  std::vector<FusionFrame> both = views.path;
  const SE3 away(Eigen::Matrix3d::Identity(), {1000, 0, 0});
  for (const FusionFrame& frame : views.path) both.push_back({frame.index, away * frame.world_from_camera});
  const auto two = fuse_frames(views, both, options_of(0.008));
  ASSERT_TRUE(one && two);
  EXPECT_NEAR(static_cast<double>(two->bricks), 2.0 * static_cast<double>(one->bricks),
              0.1 * static_cast<double>(one->bricks));
  EXPECT_EQ(open_edges(two->mesh), 0);
}

TEST(FinalFusion, NothingToFuseIsNoMesh) {
  Views views(ball(), kCamera, all_around(kCentre, 0.9));
  EXPECT_FALSE(fuse_frames(views, {}, options_of(0.005)));
  for (Frame& frame : views.frames) std::fill(frame.depth.pixels.begin(), frame.depth.pixels.end(), std::uint16_t{0});
  EXPECT_FALSE(fuse_frames(views, views.path, options_of(0.005)));
  EXPECT_FALSE(fuse_frames(views, views.path, options_of(0)));
}

TEST(FinalFusion, ADamagedFrameCostsItselfAlone) {
  Views views(ball(), kCamera, all_around(kCentre, 0.9));
  views.damaged = 11;
  const auto result = fuse_frames(views, views.path, options_of(0.008));
  ASSERT_TRUE(result);
  EXPECT_EQ(result->frames, 59);
  ASSERT_EQ(result->notes.size(), 1u);
  EXPECT_THAT(result->notes.front(), HasSubstr("frame 11: is damaged"));
}

TEST(FinalFusion, StopsWhenAsked) {
  const Views views(ball(), kCamera, all_around(kCentre, 0.9));
  FusionOptions options = options_of(0.008);
  int asked = 0, done = 0;
  options.stopping = [&] { return ++asked > 5; };
  options.on_progress = [&](const FusionProgress& progress) { done = progress.done; };
  EXPECT_FALSE(fuse_frames(views, views.path, options));
  EXPECT_EQ(done, 5);
}

TEST(FinalFusion, LessMemoryMakesVoxelsLarger) {
  const Views views(ball(), kCamera, all_around(kCentre, 0.9));
  FusionOptions options = options_of(0.004);
  options.memory = 400 * FineMap::bytes_per_brick(true);
  for (const double area : {0.0, 0.8}) {  // m²: not known, known
    options.expected_area = area;
    const auto result = fuse_frames(views, views.path, options);
    ASSERT_TRUE(result);
    EXPECT_GT(result->detail, 0.008);
    EXPECT_LE(result->bytes, options.memory);
    EXPECT_EQ(open_edges(result->mesh), 0);
    ASSERT_EQ(result->notes.size(), 1u);
    EXPECT_THAT(result->notes.front(), HasSubstr("instead of 4.0"));
  }
  options.memory = 1;
  EXPECT_THROW(fuse_frames(views, views.path, options), std::bad_alloc);
}

TEST(FinalFusion, TheDetailFollowsTheDistance) {
  const sim::AnalyticScene wall{{sim::plane({0, 0, 0}, {0, 0, 1})}};
  const Pinhole camera = test::pinhole(640, 480);
  double before = 0;
  for (const double distance : {0.8, 2.0, 5.0}) {
    const Views views(wall, camera,
                      std::vector<SE3>(3, sim::look_at({0, 0, distance}, {0, 0, 0}, Eigen::Vector3d::UnitY())));
    const auto result = fuse_frames(views, views.path, options_of(0));
    ASSERT_TRUE(result);
    EXPECT_GT(result->detail, before);
    before = result->detail;
  }
  EXPECT_NEAR(before, 0.010, 1e-9);  // the coarsest
}

TEST(FinalFusion, OptionsOutOfRangeAreErrors) {
  const Views views(ball(), kCamera, all_around(kCentre, 0.9));
  EXPECT_THAT(test::error_of([&] { fuse_frames(views, views.path, options_of(1e-6)); }), HasSubstr("0.5 mm"));
  EXPECT_THAT(test::error_of([&] { fuse_frames(views, views.path, options_of(NAN)); }), HasSubstr("0.5 mm"));
  FusionOptions options = options_of(0.004);
  options.min_readings = 0;
  EXPECT_THAT(test::error_of([&] { fuse_frames(views, views.path, options); }), HasSubstr("at least 1 reading"));
}

TEST(MeshCleanup, IslandsGoAndTheBudgetHolds) {
  const Views views(ball(), kCamera, all_around(kCentre, 0.9));
  Mesh mesh = fused(views, views.path, options_of(0.008));
  const std::size_t triangles = mesh.triangles.size(), vertices = mesh.positions.size();
  const auto first = static_cast<std::uint32_t>(vertices);
  for (const float x : {5.0f, 5.01f, 5.02f}) {
    mesh.positions.push_back({x, x == 5.01f ? 0.01f : 0.0f, 0});
    mesh.normals.push_back({0, 0, 1});
    mesh.colors.push_back({1, 2, 3});
  }
  mesh.triangles.push_back({first, first + 1, first + 2});
  EXPECT_EQ(remove_islands(1e-3, &mesh), 1u);
  EXPECT_EQ(mesh.triangles.size(), triangles);
  EXPECT_EQ(mesh.positions.size(), vertices);
  simplify(1000, &mesh);
  EXPECT_LE(mesh.triangles.size(), 1000u);
  EXPECT_GE(mesh.triangles.size(), 900u);
  EXPECT_EQ(mesh.normals.size(), mesh.positions.size());
  EXPECT_LT(test::quantile(errors_of(mesh, ball()), 0.95), 0.003);
  EXPECT_EQ(remove_islands(100, &mesh), 1u);
  EXPECT_TRUE(mesh.positions.empty());
}

TEST(FreeMemory, IsKnownHere) { EXPECT_GT(free_memory(), std::size_t{1} << 20); }

class FineMapLanes : public test::LaneTest {};

/// Every instruction set sees the same surface.
TEST_P(FineMapLanes, GivesASphere) {
  const Views views(ball(), kCamera, all_around(kCentre, 0.9));
  FineMap map(kCamera, {0.008, 20'000, true, {}}, backend());
  const std::size_t step = GetParam() == "cuda" ? 3 : 1;  // it may be a simulated one
  for (std::size_t i = 0; i < views.path.size(); i += step)
    EXPECT_EQ(map.fuse(views.read(views.path[i].index), views.path[i].world_from_camera), FineMap::Fused::yes);
  const Mesh mesh = map.extract_mesh(step > 1 ? 1 : 3);
  EXPECT_EQ(open_edges(mesh), 0);
  EXPECT_LT(test::quantile(errors_of(mesh, ball()), 0.5), 0.001);
}
PLUMBLINE_ON_EVERY_LANE_TYPE(FineMapLanes);

}  // namespace
}  // namespace plumbline
