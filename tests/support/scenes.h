// What a camera sees of an analytic scene, to the last bit of single precision: no sensor, no noise, no rounding to
// readings. The oracle of the kernels' tests, and the way between host images and a backend's planes.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "backend/maps.h"
#include "plumbline/angles.h"
#include "plumbline/image.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "sim/analytic_scene.h"

namespace plumbline::test {

/// Depth (metres) and unit normals towards the camera in its frame, zeros where there is nothing.
struct View {
  Image<float> depth, normal_x, normal_y, normal_z;

  View(int width, int height)
      : depth(width, height), normal_x(width, height), normal_y(width, height), normal_z(width, height) {}
  Eigen::Vector3d normal(int u, int v) const {
    return {double{normal_x.at(u, v)}, double{normal_y.at(u, v)}, double{normal_z.at(u, v)}};
  }
};

/// Direction of a pixel's ray with z = 1, so that a ray's parameter is the depth.
inline Eigen::Vector3d pixel_ray(const Pinhole& camera, double u, double v) {
  return {(u - double{camera.cx}) / double{camera.fx}, (v - double{camera.cy}) / double{camera.fy}, 1};
}

inline View view_of(const sim::AnalyticScene& scene, const Pinhole& camera, const SE3& world_from_camera) {
  View view(camera.width, camera.height);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d ray = world_from_camera.rotation() * pixel_ray(camera, u, v);
      const auto hit = scene.intersect(world_from_camera.translation(), ray);
      if (!hit) continue;
      const Eigen::Vector3d normal = world_from_camera.rotation().transpose() * hit->normal;
      view.depth.at(u, v) = static_cast<float>(hit->t);
      view.normal_x.at(u, v) = static_cast<float>(normal.x());
      view.normal_y.at(u, v) = static_cast<float>(normal.y());
      view.normal_z.at(u, v) = static_cast<float>(normal.z());
    }
  }
  return view;
}

/// Focal length of a Kinect for an image of this size; odd sizes are as good as even ones.
inline Pinhole pinhole(int width, int height) {
  const float f = 525.0f * static_cast<float>(width) / 640.0f;
  return {f, f, 0.5f * static_cast<float>(width - 1), 0.5f * static_cast<float>(height - 1), width, height};
}

template <class T>
Plane<T> make_plane(const Backend& backend, int width, int height) {
  return {width, height, backend};
}

template <class T>
Plane<T> to_plane(const Backend& backend, const Image<T>& image) {
  Plane<T> plane = make_plane<T>(backend, image.width, image.height);
  upload(backend, image, plane);
  return plane;
}

inline DepthLevel to_level(const Backend& backend, const Pinhole& camera, const View& view) {
  DepthLevel level(camera, backend);
  upload(backend, view.depth, level.depth);
  upload(backend, view.normal_x, level.normal_x);
  upload(backend, view.normal_y, level.normal_y);
  upload(backend, view.normal_z, level.normal_z);
  return level;
}

inline View to_view(const Backend& backend, const DepthLevel& level) {
  View view(level.camera.width, level.camera.height);
  view.depth = download(backend, level.depth);
  view.normal_x = download(backend, level.normal_x);
  view.normal_y = download(backend, level.normal_y);
  view.normal_z = download(backend, level.normal_z);
  return view;
}

/// Elements beside the image's rows that are not zero. Stencils read them as "no reading", so every kernel must leave
/// them alone.
template <class T>
int dirty_padding(const Backend& backend, const Plane<T>& plane) {
  const PlaneView<T> view = plane.view();
  const std::vector<T> all = plane.elements().download(backend);
  int dirty = 0;
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.stride; ++x) {
      const bool in_image = x >= Plane<T>::kPadding && x < Plane<T>::kPadding + view.width;
      if (!in_image &&
          all[static_cast<std::size_t>(y) * static_cast<std::size_t>(view.stride) + static_cast<std::size_t>(x)] != T{})
        ++dirty;
    }
  }
  return dirty;
}

inline int dirty_padding(const Backend& backend, const DepthLevel& level) {
  return dirty_padding(backend, level.depth) + dirty_padding(backend, level.normal_x) +
         dirty_padding(backend, level.normal_y) + dirty_padding(backend, level.normal_z);
}

inline double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// Value below which a fraction of the values lie; 0 for none.
inline double quantile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0;
  const auto at = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(engine_); }
  Eigen::Vector3d direction() {
    std::normal_distribution<double> normal;
    return Eigen::Vector3d(normal(engine_), normal(engine_), normal(engine_)).normalized();
  }
  /// A turn of `angle` (radians) and a move of `length` (metres), each in a random direction.
  SE3 motion(double angle, double length) {
    const Eigen::Vector3d axis = direction();
    return {so3::exp(axis * angle), direction() * length};
  }

 private:
  std::mt19937 engine_;
};

}  // namespace plumbline::test
