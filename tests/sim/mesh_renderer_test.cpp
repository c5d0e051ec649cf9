#include "sim/mesh_renderer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>
#include <string>

#include "plumbline/error.h"
#include "plumbline/frame.h"
#include "plumbline/image.h"
#include "plumbline/mesh.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "plumbline/trajectory.h"
#include "sim/analytic_scene.h"

namespace plumbline::sim {
namespace {

using Eigen::Vector3d;

constexpr Pinhole kCamera{260, 260, 159.5f, 119.5f, 320, 240};

/// Pictures to look at, where the environment names a folder for them.
void keep(const ColorImage& image, const std::string& name) {
  const char* folder = std::getenv("PLUMBLINE_PICTURES");
  if (folder == nullptr) return;
  std::ofstream file(std::filesystem::path(folder) / (name + ".ppm"), std::ios::binary);
  file << "P6\n" << image.width << " " << image.height << "\n255\n";
  file.write(reinterpret_cast<const char*>(image.pixels.data()), static_cast<std::streamsize>(image.pixels.size()));
}

Mesh::Float3 to_float(const Vector3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

/// A square of 2 × 2 × half metres in the plane z = 0 whose free side is +z.
Mesh square(double half, Mesh::Rgb color) {
  const float h = static_cast<float>(half);
  Mesh mesh;
  mesh.positions = {{-h, -h, 0}, {h, -h, 0}, {h, h, 0}, {-h, h, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.colors.assign(4, color);
  return mesh;
}

void append_sphere(Mesh* mesh, const Vector3d& center, double radius, int rings, Mesh::Rgb color) {
  const auto first = static_cast<std::uint32_t>(mesh->positions.size());
  const int columns = 2 * rings;
  for (int i = 0; i <= rings; ++i) {
    for (int j = 0; j < columns; ++j) {
      const double polar = std::numbers::pi * i / rings, azimuth = 2 * std::numbers::pi * j / columns;
      const Vector3d n(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar));
      mesh->positions.push_back(to_float(center + radius * n));
      mesh->colors.push_back(color);
    }
  }
  const auto at = [&](int i, int j) { return first + static_cast<std::uint32_t>(i * columns + j % columns); };
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < columns; ++j) {
      mesh->triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh->triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
}

/// The first view of the desk as a mesh of its depth image, as a scanner's raw mesh would be.
Mesh desk_relief(int width, int height, const SE3& pose) {
  const AnalyticScene scene = desk_corner();
  const float f = 0.82f * static_cast<float>(width);
  const Pinhole camera{f,     f,     0.5f * static_cast<float>(width - 1), 0.5f * static_cast<float>(height - 1),
                       width, height};
  const Frame frame = render(scene, camera, pose);
  Mesh mesh;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const double z = frame.depth.at(u, v) / frame.depth_scale;
      const Vector3d ray((u - double{camera.cx}) / camera.fx, (v - double{camera.cy}) / camera.fy, 1);
      mesh.positions.push_back(to_float(pose * Vector3d(z * ray)));
      mesh.colors.push_back({frame.color.at(u, v, 0), frame.color.at(u, v, 1), frame.color.at(u, v, 2)});
    }
  }
  const auto index = [&](int u, int v) { return static_cast<std::uint32_t>(v * width + u); };
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const auto z = [&](std::uint32_t i) { return frame.depth.pixels[i] / frame.depth_scale; };
    const double low = std::min({z(a), z(b), z(c)}), high = std::max({z(a), z(b), z(c)});
    if (low > 0 && high - low < 0.04) mesh.triangles.push_back({a, b, c});
  };
  for (int v = 0; v + 1 < height; ++v) {
    for (int u = 0; u + 1 < width; ++u) {
      add(index(u, v), index(u, v + 1), index(u + 1, v));
      add(index(u + 1, v), index(u, v + 1), index(u + 1, v + 1));
    }
  }
  return mesh;
}

int luminance(const ColorImage& image, int x, int y) {
  return image.at(x, y, 0) + image.at(x, y, 1) + image.at(x, y, 2);
}

TEST(MeshRenderer, AnEmptyMeshIsAGradientFromTopToBottom) {
  const ColorImage image = render_mesh({}, kCamera, SE3());
  ASSERT_EQ(image.channels, 3);
  EXPECT_GT(luminance(image, 100, 0), luminance(image, 100, 239));
  EXPECT_GT(luminance(image, 100, 239), 3 * 200);
  EXPECT_EQ(luminance(image, 10, 120), luminance(image, 300, 120));
}

TEST(MeshRenderer, SquareCoversThePixelsThatItsProjectionDoes) {
  RenderOptions options;
  options.occlusion_rays = 0;
  const ColorImage image = render_mesh(square(0.5, {200, 30, 30}), kCamera, look_at({0, -1e-3, 2}, {0, 0, 0}), options);
  // 0.5 m at 2 m with f = 260: 65 pixels to either side of the centre.
  const auto is_red = [&](int x, int y) { return image.at(x, y, 0) > 2 * image.at(x, y, 1); };
  for (const int reach : {0, 30, 63}) {
    EXPECT_TRUE(is_red(160 + reach, 120));
    EXPECT_TRUE(is_red(159 - reach, 120));
    EXPECT_TRUE(is_red(160, 120 + reach));
    EXPECT_TRUE(is_red(160, 119 - reach));
  }
  EXPECT_FALSE(is_red(160 + 67, 120));
  EXPECT_FALSE(is_red(159 - 67, 120));
  EXPECT_FALSE(is_red(160, 120 + 67));
}

TEST(MeshRenderer, EdgesAreAntiAliased) {
  const SE3 view = look_at({0.1, -0.3, 2}, {0, 0, 0}, Vector3d(0.3, 1, 0));
  RenderOptions options;
  options.occlusion_rays = 0;
  options.background_top = options.background_bottom = {255, 255, 255};
  const ColorImage smooth = render_mesh(square(0.5, {0, 0, 0}), kCamera, view, options);
  options.samples = 1;
  const ColorImage hard = render_mesh(square(0.5, {0, 0, 0}), kCamera, view, options);
  int between = 0, between_hard = 0;
  for (std::size_t i = 0; i < smooth.pixels.size(); i += 3) {
    between += smooth.pixels[i] > 10 && smooth.pixels[i] < 245;
    between_hard += hard.pixels[i] > 10 && hard.pixels[i] < 245;
  }
  EXPECT_EQ(between_hard, 0);
  EXPECT_GT(between, 200);
}

TEST(MeshRenderer, BackFacesAreDarkerOrHidden) {
  const Mesh mesh = square(0.5, {180, 170, 160});
  const SE3 front = look_at({0.1, 0.2, 2}, {0, 0, 0}), back = look_at({0.1, 0.2, -2}, {0, 0, 0});
  const int bright = luminance(render_mesh(mesh, kCamera, front), 160, 120);
  const int dark = luminance(render_mesh(mesh, kCamera, back), 160, 120);
  EXPECT_LT(dark, 0.7 * bright);
  RenderOptions options;
  options.back_faces = BackFaces::hidden;
  const ColorImage hidden = render_mesh(mesh, kCamera, back, options),
                   nothing = render_mesh({}, kCamera, back, options);
  EXPECT_EQ(hidden.pixels, nothing.pixels);
  EXPECT_EQ(luminance(render_mesh(mesh, kCamera, front, options), 160, 120), bright);
}

TEST(MeshRenderer, HiddenBackFacesShowWhatIsBehindThem) {
  Mesh mesh = square(0.5, {0, 200, 0});  // seen from below through its back
  const Mesh behind = square(0.5, {200, 0, 0});
  for (Mesh::Float3 p : behind.positions) mesh.positions.push_back({p.x, p.y, p.z + 0.5f});
  mesh.colors.insert(mesh.colors.end(), behind.colors.begin(), behind.colors.end());
  mesh.triangles.push_back({4, 6, 5});
  mesh.triangles.push_back({4, 7, 6});
  RenderOptions options;
  options.back_faces = BackFaces::hidden;
  const ColorImage image = render_mesh(mesh, kCamera, look_at({0, 0.01, -2}, {0, 0, 0}), options);
  EXPECT_GT(image.at(160, 120, 0), 60);
  EXPECT_LT(image.at(160, 120, 1), 10);
}

TEST(MeshRenderer, OcclusionDarkensACrease) {
  Mesh mesh = square(1, {200, 200, 200});
  const Mesh wall = square(1, {200, 200, 200});  // turned up about the y axis, at x = −1, facing +x
  for (const Mesh::Float3& p : wall.positions) mesh.positions.push_back({-1, p.y, 1 - p.x});
  mesh.colors.insert(mesh.colors.end(), wall.colors.begin(), wall.colors.end());
  for (const Mesh::Triangle& t : wall.triangles) mesh.triangles.push_back({t.a + 4, t.b + 4, t.c + 4});
  const SE3 view = look_at({0, 0, 2.5}, {0, 1e-3, 0}, {0, 1, 0});
  RenderOptions options;
  options.occlusion_distance = 0.5;
  const ColorImage shaded = render_mesh(mesh, kCamera, view, options);
  options.occlusion_rays = 0;
  const ColorImage flat = render_mesh(mesh, kCamera, view, options);
  const int crease = 160 - 95, open = 160 + 40;  // −0.9 m and 0.4 m
  EXPECT_LT(luminance(shaded, crease, 120), 0.93 * luminance(flat, crease, 120));
  EXPECT_NEAR(luminance(shaded, open, 120), luminance(flat, open, 120), 3);
}

TEST(MeshRenderer, SameBitsForAnyNumberOfThreads) {
  const Trajectory path = orbit({.frames = 60});
  const Mesh mesh = desk_relief(160, 120, path[0].world_from_camera);
  RenderOptions options;
  options.path = path;
  options.samples = 4;
  std::vector<ColorImage> images;
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 8);  // more than the machine may have
  for (const int threads : {1, 2, 7}) {
    tbb::task_arena arena(threads);
    arena.execute([&] {
      const MeshRenderer renderer(mesh);
      images.push_back(renderer.render(kCamera, renderer.default_view(kCamera), options));
    });
  }
  EXPECT_EQ(images[0].pixels, images[1].pixels);
  EXPECT_EQ(images[0].pixels, images[2].pixels);
}

TEST(MeshRenderer, PathIsDrawnBeforeTheMeshAndHiddenBehindIt) {
  const Mesh mesh = square(1, {250, 250, 250});
  const SE3 view = look_at({0, -1e-3, 2}, {0, 0, 0});
  const ColorImage without = render_mesh(mesh, kCamera, view);
  for (const double z : {0.3, -0.3}) {
    RenderOptions options;
    options.path_radius = 0.02;
    for (const double x : {-0.3, 0.0, 0.3}) options.path.push_back({0, SE3(Eigen::Matrix3d::Identity(), {x, 0, z})});
    const ColorImage with = render_mesh(mesh, kCamera, view, options);
    EXPECT_EQ(with.pixels != without.pixels, z > 0);
    if (z < 0) continue;
    const auto blue = [&](int x) { return with.at(x, 120, 2) - with.at(x, 120, 0); };
    EXPECT_GT(blue(160 - 40), 50);   // the beginning
    EXPECT_LT(blue(160 + 40), -50);  // the end
  }
}

TEST(MeshRenderer, DefaultViewFitsTheMeshAndSeesItsFreeSide) {
  Mesh mesh = desk_relief(160, 120, orbit({.frames = 1})[0].world_from_camera);
  mesh.positions.push_back({100, 100, 100});  // an outlier does not shrink the picture
  mesh.colors.push_back({0, 0, 0});
  const MeshRenderer renderer(mesh);
  const SE3 view = renderer.default_view(kCamera);
  EXPECT_LT(view.rotation().col(1).z(), -0.5) << "up is up";
  EXPECT_GT(view.translation().z(), 0.5) << "from above";
  double widest = 0;
  int inside = 0;
  for (const Mesh::Float3& p : mesh.positions) {
    const Vector3d c =
        view.inverse() * Vector3d(static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z));
    const double x = std::abs(c.x() / c.z() * kCamera.fx) / 160, y = std::abs(c.y() / c.z() * kCamera.fy) / 120;
    if (c.z() <= 0 || std::max(x, y) > 1) continue;
    ++inside;
    widest = std::max({widest, x, y});
  }
  EXPECT_GT(inside, 0.97 * static_cast<double>(mesh.positions.size()));
  EXPECT_GT(widest, 0.85);
  // The relief was seen from the room's open side, so its front faces that way.
  EXPECT_GT(view.translation().x() + view.translation().y(), 0.5);
}

TEST(MeshRenderer, DefaultViewWithThePathShowsWhatWasScannedFromNearBy) {
  Mesh mesh = square(0.5, {200, 200, 200});  // a table, and a wall far behind it, turned up about the y axis
  const Mesh wall = square(2, {200, 200, 200});
  for (const Mesh::Float3& p : wall.positions) mesh.positions.push_back({-6, p.y, 2 - p.x});
  for (const Mesh::Rgb& c : wall.colors) mesh.colors.push_back(c);
  for (const Mesh::Triangle& t : wall.triangles) mesh.triangles.push_back({t.a + 4, t.b + 4, t.c + 4});
  Trajectory path;
  for (int i = 0; i < 20; ++i) path.push_back({i, look_at({0.8, 0.05 * i - 0.5, 0.8}, {0, 0, 0})});
  const MeshRenderer renderer(mesh);
  const SE3 all = renderer.default_view(kCamera), near = renderer.default_view(kCamera, Vector3d::UnitZ(), path);
  EXPECT_LT(near.translation().norm(), 0.4 * all.translation().norm());
  for (const Mesh::Float3& p : square(0.5, {}).positions) {
    const Vector3d c = near.inverse() * Vector3d(static_cast<double>(p.x), static_cast<double>(p.y), 0);
    EXPECT_LT(std::abs(c.x() / c.z() * kCamera.fx), 160);
    EXPECT_LT(std::abs(c.y() / c.z() * kCamera.fy), 120);
  }
}

TEST(MeshRenderer, BadInputIsRefused) {
  Mesh mesh = square(1, {1, 2, 3});
  RenderOptions options;
  options.samples = 0;
  EXPECT_THROW(render_mesh(mesh, kCamera, SE3(), options), Error);
  EXPECT_THROW(render_mesh(mesh, Pinhole{}, SE3()), Error);
  EXPECT_THROW(default_view(mesh, kCamera, Vector3d::Zero()), Error);
  EXPECT_EQ(default_view({}, kCamera).translation(), Vector3d::Zero());
  mesh.triangles.push_back({0, 1, 4});
  EXPECT_THROW(MeshRenderer{mesh}, Error);
}

TEST(MeshRenderer, VerticesThatAreNotFiniteAreLeftOut) {
  Mesh mesh = square(0.5, {180, 170, 160});
  mesh.positions.push_back({std::numeric_limits<float>::quiet_NaN(), 0, 0});
  mesh.colors.push_back({0, 0, 0});
  mesh.triangles.push_back({0, 1, 4});
  RenderOptions options;
  options.occlusion_distance = 0.1;
  const SE3 view = look_at({0.1, 0.2, 2}, {0, 0, 0});
  const ColorImage image = render_mesh(mesh, kCamera, view, options);
  EXPECT_LT(image.at(160, 140, 2), 200);
}

/// Not a comparison with a stored picture: that would hold for one compiler only. A person looks at it.
TEST(MeshRenderer, PictureOfTheDesk) {
  const int level = std::getenv("PLUMBLINE_PICTURES") != nullptr ? 0 : 2;  // small where nobody looks
  const Pinhole camera = Pinhole{1040, 1040, 639.5f, 479.5f, 1280, 960}.level(level);
  const Trajectory path = orbit();
  Mesh mesh = desk_relief(640, 480, path[0].world_from_camera);
  RenderOptions options;
  options.path = path;
  options.path_radius = 0.008;
  const MeshRenderer renderer(mesh);
  const ColorImage colored = renderer.render(camera, renderer.default_view(camera), options);
  keep(colored, "desk_color");
  options.vertex_colors = false;
  const ColorImage clay = renderer.render(camera, renderer.default_view(camera), options);
  keep(clay, "desk_clay");
  EXPECT_NE(colored.pixels, clay.pixels);

  Mesh objects = square(1.2, {210, 208, 204});
  append_sphere(&objects, {-0.3, 0.1, 0.35}, 0.35, 48, {214, 96, 77});
  append_sphere(&objects, {0.35, 0.3, 0.22}, 0.22, 48, {67, 147, 195});
  append_sphere(&objects, {0.25, -0.35, 0.15}, 0.15, 48, {246, 191, 92});
  const ColorImage spheres = render_mesh(objects, camera, default_view(objects, camera));
  keep(spheres, "spheres");
  EXPECT_GT(luminance(spheres, 10, 10), 700);
}

}  // namespace
}  // namespace plumbline::sim
