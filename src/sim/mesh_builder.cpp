#include "sim/mesh_builder.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/random.h"
#include "plumbline/mesh.h"

namespace plumbline::sim {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

double smooth(double t) { return t * t * (3 - 2 * t); }

double corner_value(std::int64_t x, std::int64_t y, std::int64_t z, std::uint64_t key) {
  const std::uint64_t row = stream(stream(key, static_cast<std::uint64_t>(x)), static_cast<std::uint64_t>(y));
  return 2 * uniform_at(row, static_cast<std::uint64_t>(z)) - 1;
}

int cells(double length, double cell) { return std::clamp(static_cast<int>(std::ceil(length / cell)), 1, 400); }

/// sign(v) |v|^p.
double signed_power(double v, double p) { return std::copysign(std::pow(std::abs(v), p), v); }

/// Point at share s of a smooth curve through the points (uniform Catmull–Rom).
Vector3d curve_point(const std::vector<Vector3d>& p, double s) {
  const auto last = static_cast<std::ptrdiff_t>(p.size()) - 1;
  const double at = s * static_cast<double>(last);
  const auto i = std::min(static_cast<std::ptrdiff_t>(at), last - 1);
  const double t = at - static_cast<double>(i);
  const auto get = [&](std::ptrdiff_t k) {
    return p[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(k, 0, last))];
  };
  const Vector3d a = get(i - 1), b = get(i), c = get(i + 1), d = get(i + 2);
  return 0.5 * (2 * b + t * (c - a) + t * t * (2 * a - 5 * b + 4 * c - d) + t * t * t * (3 * b - a - 3 * c + d));
}

}  // namespace

double lattice_noise(const Vector3d& p, std::uint64_t key) {
  const Vector3d floor = p.array().floor();
  const auto x = static_cast<std::int64_t>(floor.x()), y = static_cast<std::int64_t>(floor.y()),
             z = static_cast<std::int64_t>(floor.z());
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int dx = corner & 1, dy = corner >> 1 & 1, dz = corner >> 2;
    const Vector3d offset = p - floor - Vector3d(dx, dy, dz);
    const double weight =
        smooth(1 - std::abs(offset.x())) * smooth(1 - std::abs(offset.y())) * smooth(1 - std::abs(offset.z()));
    sum += weight * corner_value(x + dx, y + dy, z + dz, key);
  }
  return sum;
}

Mesh::Rgb blend(Mesh::Rgb a, Mesh::Rgb b, double share) {
  const double s = std::clamp(share, 0.0, 1.0);
  const auto channel = [s](std::uint8_t u, std::uint8_t v) { return static_cast<std::uint8_t>(u + s * (v - u) + 0.5); };
  return {channel(a.r, b.r), channel(a.g, b.g), channel(a.b, b.b)};
}

Paint plain(Mesh::Rgb color) {
  return [color](const Vector3d&) { return color; };
}

Paint mottled(Mesh::Rgb a, Mesh::Rgb b, const Vector3d& size, std::uint64_t key) {
  return [=](const Vector3d& p) {
    const Vector3d q = p.cwiseQuotient(size);
    return blend(a, b, 0.5 + 0.4 * lattice_noise(q, key) + 0.25 * lattice_noise(2.3 * q, key + 1));
  };
}

Paint wood(Mesh::Rgb light, Mesh::Rgb dark, std::uint64_t key) {
  return [=](const Vector3d& p) {
    const double bend = 0.4 * lattice_noise({p.x() / 0.3, p.y() / 0.15, p.z() / 0.15}, key);
    const double ring = std::sin(2 * std::numbers::pi * ((p.y() + p.z()) / 0.11 + bend));
    return blend(light, dark, 0.4 + 0.3 * ring + 0.3 * lattice_noise({p.x() / 0.2, p.y() / 0.03, p.z() / 0.03}, key));
  };
}

Paint checkered(Mesh::Rgb a, Mesh::Rgb b, double period) {
  return [=](const Vector3d& p) {
    // Off by a third, so that faces through the origin do not lie on a boundary.
    const Vector3d cell = (p / period + Vector3d::Constant(1.0 / 3)).array().floor();
    const double half = cell.sum() / 2;
    return half == std::floor(half) ? a : b;
  };
}

SE3 stand(double x, double y, double z, double yaw) {
  return {Eigen::AngleAxisd(yaw, Vector3d::UnitZ()).toRotationMatrix(), Vector3d(x, y, z)};
}

SE3 turned(double x, double y, double z, double about_x, double about_y, double about_z) {
  const Matrix3d rotation =
      (Eigen::AngleAxisd(about_z, Vector3d::UnitZ()) * Eigen::AngleAxisd(about_y, Vector3d::UnitY()) *
       Eigen::AngleAxisd(about_x, Vector3d::UnitX()))
          .toRotationMatrix();
  return {rotation, Vector3d(x, y, z)};
}

namespace {

/// Two triangles for each cell of a grid whose vertices stand row by row from `first` on.
void add_cells(std::uint32_t first, int rows, int columns, Mesh* mesh) {
  const auto at = [&](int i, int j) { return first + static_cast<std::uint32_t>(i * (columns + 1) + j); };
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      mesh->triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh->triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
}

}  // namespace

void MeshBuilder::grid(const SE3& pose, int rows, int columns, const std::function<Vector3d(double, double)>& point,
                       const Paint& paint) {
  const auto first = static_cast<std::uint32_t>(mesh_.positions.size());
  for (int i = 0; i <= rows; ++i) {
    for (int j = 0; j <= columns; ++j) {
      const Vector3d local = point(static_cast<double>(i) / rows, static_cast<double>(j) / columns);
      const Eigen::Vector3f world = (pose * local).cast<float>();
      mesh_.positions.push_back({world.x(), world.y(), world.z()});
      mesh_.colors.push_back(paint(local));
    }
  }
  add_cells(first, rows, columns, &mesh_);
}

void MeshBuilder::box(const SE3& pose, const Vector3d& half, const Paint& paint) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const int u = (axis + (side > 0 ? 1 : 2)) % 3, v = (axis + (side > 0 ? 2 : 1)) % 3;
      const auto point = [&](double s, double t) {
        Vector3d p;
        p[axis] = side * half[axis];
        p[u] = (2 * s - 1) * half[u];
        p[v] = (2 * t - 1) * half[v];
        return p;
      };
      grid(pose, cells(2 * half[u], cell), cells(2 * half[v], cell), point, paint);
    }
  }
}

void MeshBuilder::blob(const SE3& pose, const Vector3d& half, const Paint& paint, double power, int rings) {
  const double exponent = 2 / power;
  const auto point = [&](double s, double t) {
    const double polar = std::numbers::pi * s, azimuth = 2 * std::numbers::pi * t;
    const double ring = signed_power(std::sin(polar), exponent);
    return Vector3d(half.x() * ring * signed_power(std::cos(azimuth), exponent),
                    half.y() * ring * signed_power(std::sin(azimuth), exponent),
                    half.z() * signed_power(std::cos(polar), exponent));
  };
  grid(pose, rings, 2 * rings, point, paint);
}

void MeshBuilder::lathe(const SE3& pose, const std::vector<Vector2d>& profile, const Paint& paint, int segments) {
  const auto last = static_cast<double>(profile.size() - 1);
  const auto point = [&](double s, double t) {
    const double at = s * last;
    const auto i = std::min(static_cast<std::size_t>(at + 1e-9), profile.size() - 2);
    const double share = at - static_cast<double>(i);
    const Vector2d p = profile[i] + share * (profile[i + 1] - profile[i]);
    const double azimuth = -2 * std::numbers::pi * t;
    return Vector3d(p.x() * std::cos(azimuth), p.x() * std::sin(azimuth), p.y());
  };
  grid(pose, static_cast<int>(profile.size() - 1), segments, point, paint);
}

void MeshBuilder::cylinder(const SE3& pose, double radius, double height, const Paint& paint, int segments) {
  const int steps = cells(height, cell);
  std::vector<Vector2d> profile = {{0, 0}};
  for (int i = 0; i <= steps; ++i) profile.emplace_back(radius, height * i / steps);
  profile.emplace_back(0, height);
  lathe(pose, profile, paint, segments);
}

void MeshBuilder::tube(const SE3& pose, const std::vector<Vector3d>& path, double radius, const Paint& paint) {
  const auto point = [&](double s, double t) {
    const Vector3d centre = curve_point(path, s);
    const Vector3d along = (curve_point(path, std::min(1.0, s + 1e-3)) - curve_point(path, std::max(0.0, s - 1e-3)));
    // A reference direction that no path of ours follows keeps the rings from twisting.
    const Vector3d side = along.cross(Vector3d(0.31, 0.17, 0.94)).normalized();
    const Vector3d other = along.normalized().cross(side);
    const double azimuth = 2 * std::numbers::pi * t;
    return Vector3d(centre + radius * (std::cos(azimuth) * side - std::sin(azimuth) * other));
  };
  grid(pose, static_cast<int>(path.size() - 1) * 6, 10, point, paint);
}

void MeshBuilder::sheet(const SE3& pose, const Vector2d& half, const std::function<double(double, double)>& height,
                        const Paint& paint, bool two_sided) {
  constexpr double kThickness = 0.002;
  const int rows = cells(2 * half.x(), cell), columns = cells(2 * half.y(), cell);
  const auto point = [&](double s, double t) {
    const double x = (2 * s - 1) * half.x(), y = (2 * t - 1) * half.y();
    return Vector3d(x, y, height(x, y));
  };
  grid(pose, rows, columns, point, paint);
  if (!two_sided) return;
  const auto back = [&](double s, double t) { return Vector3d(point(s, 1 - t) - kThickness * Vector3d::UnitZ()); };
  grid(pose, rows, columns, back, paint);
}

void MeshBuilder::sheet(const SE3& pose, const Vector2d& half, const Paint& paint) {
  sheet(
      pose, half, [](double, double) { return 0.0; }, paint);
}

}  // namespace plumbline::sim
