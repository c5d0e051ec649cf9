// The undistorter that sequences are read through: core/undistort.h on images whose truth is known.
#include "core/undistort.h"
#include "plumbline/image.h"
#include "plumbline/pinhole.h"

#include <gtest/gtest.h>

#include <cmath>

namespace plumbline {
namespace {

const Pinhole kCamera{517.3f, 516.5f, 318.6f, 255.3f, 640, 480};
const Distortion kDistortion{0.2624, -0.9531, -0.0054, 0.0026, 1.1633};  // TUM freiburg1

/// The pinhole's ray through pixel (u, v): (x, y, 1).
double ray_x(double u) { return (u - kCamera.cx) / kCamera.fx; }
double ray_y(double v) { return (v - kCamera.cy) / kCamera.fy; }

/// Inverts Distortion::apply by fixed-point iteration, for pixels (u, v) of the distorted image.
void ray_of_distorted_pixel(double u, double v, double* x, double* y) {
  const double xd = ray_x(u), yd = ray_y(v);
  *x = xd, *y = yd;
  for (int i = 0; i < 100; ++i) {
    double x_again = 0, y_again = 0;
    kDistortion.apply(*x, *y, &x_again, &y_again);
    *x += xd - x_again;
    *y += yd - y_again;
  }
}

/// Depth (in 1/5000 m) of the plane n·p = d along the ray (x, y, 1).
double plane_reading(double x, double y) { return 5000 * 1.5 / (0.3 * x - 0.2 * y + 0.93); }

/// What a camera with this lens would deliver of a scene with `reading(x, y)` along each ray.
template <class Reading>
DepthImage seen_through_lens(Reading&& reading) {
  DepthImage depth(kCamera.width, kCamera.height);
  for (int v = 0; v < depth.height; ++v)
    for (int u = 0; u < depth.width; ++u) {
      double x = 0, y = 0;
      ray_of_distorted_pixel(u, v, &x, &y);
      depth.at(u, v) = static_cast<std::uint16_t>(std::lround(reading(x, y)));
    }
  return depth;
}

TEST(Undistorter, SlantedPlaneComesOutAsAPinholeSeesIt) {
  DepthImage depth = seen_through_lens(plane_reading);
  const DepthImage distorted = depth;
  Undistorter(kCamera, kDistortion).apply(depth);
  int filled = 0;
  double worst = 0, worst_before = 0;
  for (int v = 0; v < depth.height; ++v)
    for (int u = 0; u < depth.width; ++u) {
      const double truth = plane_reading(ray_x(u), ray_y(v));
      worst_before = std::max(worst_before, std::abs(distorted.at(u, v) - truth));
      if (depth.at(u, v) == 0) continue;
      ++filled;
      worst = std::max(worst, std::abs(depth.at(u, v) - truth));
    }
  EXPECT_GT(filled, 0.9 * 640 * 480);
  EXPECT_GT(worst_before, 20);  // the lens does displace it
  // Readings are rounded twice (0.5 each); positions half a pixel out of the image are clamped to its border.
  EXPECT_LT(worst, 5);
}

TEST(Undistorter, InteriorOfAPlaneIsExactToRounding) {
  DepthImage depth = seen_through_lens(plane_reading);
  Undistorter(kCamera, kDistortion).apply(depth);
  for (int v = 20; v < depth.height - 20; ++v)
    for (int u = 20; u < depth.width - 20; ++u) {
      const double truth = plane_reading(ray_x(u), ray_y(v));
      ASSERT_NEAR(depth.at(u, v), truth, 1.1) << u << " " << v;
    }
}

TEST(Undistorter, AnEdgeIsNotSmeared) {
  const auto two_walls = [](double x, double) { return x < 0.05 ? 5000.0 : 8000.0; };
  DepthImage depth = seen_through_lens(two_walls);
  Undistorter(kCamera, kDistortion).apply(depth);
  int near_wall = 0, far_wall = 0;
  for (int v = 0; v < depth.height; ++v)
    for (int u = 0; u < depth.width; ++u) {
      const int reading = depth.at(u, v);
      ASSERT_TRUE(reading == 0 || reading == 5000 || reading == 8000) << reading;
      near_wall += reading == 5000;
      far_wall += reading == 8000;
      // The edge stands where the pinhole sees it, within the half pixel of the nearest neighbour and the rounding.
      if (reading != 0) {
        const double edge = kCamera.cx + 0.05 * kCamera.fx;
        if (u < edge - 1.5) {
          ASSERT_EQ(reading, 5000);
        }
        if (u > edge + 1.5) {
          ASSERT_EQ(reading, 8000);
        }
      }
    }
  EXPECT_GT(near_wall, 100000);
  EXPECT_GT(far_wall, 100000);
}

TEST(Undistorter, HolesStayHoles) {
  DepthImage depth(640, 480);
  for (std::uint16_t& v : depth.pixels) v = 6000;
  for (int v = 200; v < 260; ++v)
    for (int u = 300; u < 360; ++u) depth.at(u, v) = 0;
  Undistorter(kCamera, kDistortion).apply(depth);
  int holes = 0;
  for (int v = 100; v < 400; ++v)
    for (int u = 100; u < 500; ++u) {
      ASSERT_TRUE(depth.at(u, v) == 0 || depth.at(u, v) == 6000);
      holes += depth.at(u, v) == 0;
    }
  EXPECT_NEAR(holes, 3600, 200);
}

TEST(Undistorter, ColorFollowsTheLensToo) {
  // A horizontal ramp of the ray's direction: the pinhole image of it is linear in u.
  const auto shade = [](double x) { return 128 + 150 * x; };
  ColorImage color(640, 480, 3);
  for (int v = 0; v < 480; ++v)
    for (int u = 0; u < 640; ++u) {
      double x = 0, y = 0;
      ray_of_distorted_pixel(u, v, &x, &y);
      for (int c = 0; c < 3; ++c) color.at(u, v, c) = static_cast<std::uint8_t>(std::lround(shade(x)) + c);
    }
  Undistorter(kCamera, kDistortion).apply(color);
  for (int v = 20; v < 460; ++v)
    for (int u = 20; u < 620; ++u)
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(color.at(u, v, c), shade(ray_x(u)) + c, 1.2);
}

TEST(Undistorter, WithoutDistortionNothingChanges) {
  const Undistorter identity(kCamera, {});
  EXPECT_TRUE(identity.is_identity());
  DepthImage depth(640, 480);
  for (std::size_t i = 0; i < depth.pixels.size(); ++i) depth.pixels[i] = static_cast<std::uint16_t>(i);
  const DepthImage before = depth;
  identity.apply(depth);
  EXPECT_TRUE(depth.pixels == before.pixels);
}

}  // namespace
}  // namespace plumbline
