// Surfaces from a few generating forms, tessellated and painted, collected in one mesh.
#pragma once

#include <functional>
#include <vector>

#include "plumbline/mesh.h"
#include "plumbline/se3.h"

namespace plumbline::sim {

/// Colour of a point given in the form's own frame, metres.
using Paint = std::function<Mesh::Rgb(const Eigen::Vector3d& local)>;

/// Smooth noise in [−1, 1] with features of about one unit (value noise on a lattice: Perlin 1985).
double lattice_noise(const Eigen::Vector3d& p, std::uint64_t key = 0);

Mesh::Rgb blend(Mesh::Rgb a, Mesh::Rgb b, double share);
Paint plain(Mesh::Rgb color);
/// Two colours mixed by noise with features of `size` metres along each axis.
Paint mottled(Mesh::Rgb a, Mesh::Rgb b, const Eigen::Vector3d& size, std::uint64_t key = 0);
/// Grain along local x.
Paint wood(Mesh::Rgb light, Mesh::Rgb dark, std::uint64_t key = 0);
/// Squares of `period` metres.
Paint checkered(Mesh::Rgb a, Mesh::Rgb b, double period);

/// Pose of something that stands at (x, y, z), turned by `yaw` radians about z.
SE3 stand(double x, double y, double z, double yaw = 0);
/// Turned about its own axes x, y, z by radians, in the order z, y, x.
SE3 turned(double x, double y, double z, double about_x, double about_y, double about_z);

/// Free sides face out of the forms. All lengths are metres; poses are world_from_form.
class MeshBuilder {
 public:
  /// Largest edge of the triangles of flat forms; colour varies at this scale.
  double cell = 0.03;

  /// Box about its centre.
  void box(const SE3& pose, const Eigen::Vector3d& half, const Paint& paint);
  /// Superellipsoid about its centre: |x/a|^p + |y/b|^p + |z/c|^p = 1; p = 2 an ellipsoid, larger a cushion, a brick.
  void blob(const SE3& pose, const Eigen::Vector3d& half, const Paint& paint, double power = 2, int rings = 20);
  /// Surface of revolution about local z through (radius, z), from the bottom of the outside onwards.
  void lathe(const SE3& pose, const std::vector<Eigen::Vector2d>& profile, const Paint& paint, int segments = 32);
  /// Cylinder with caps, standing on local z = 0.
  void cylinder(const SE3& pose, double radius, double height, const Paint& paint, int segments = 24);
  /// Round tube along a polyline that is smoothed, with open ends.
  void tube(const SE3& pose, const std::vector<Eigen::Vector3d>& path, double radius, const Paint& paint);
  /// The displaced rectangle |x| ≤ half.x, |y| ≤ half.y, z = height(x, y), free side towards +z; `two_sided` adds the
  /// back 2 mm below.
  void sheet(const SE3& pose, const Eigen::Vector2d& half, const std::function<double(double, double)>& height,
             const Paint& paint, bool two_sided = false);
  /// Flat rectangle.
  void sheet(const SE3& pose, const Eigen::Vector2d& half, const Paint& paint);

  const Mesh& mesh() const { return mesh_; }

 private:
  /// (rows + 1) × (columns + 1) points at (row, column) shares in [0, 1]; ∂row × ∂column points to the free side.
  void grid(const SE3& pose, int rows, int columns, const std::function<Eigen::Vector3d(double, double)>& point,
            const Paint& paint);

  Mesh mesh_;
};

}  // namespace plumbline::sim
