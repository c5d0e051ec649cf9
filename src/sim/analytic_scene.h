// Scenes of analytic solids with exact ray intersection: the oracle of tracking and mapping, and what the demo scans.
//
// The world is in metres with z up. The camera's axes are x right, y down, z forward.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "plumbline/frame.h"
#include "plumbline/mesh.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"

namespace plumbline::sim {

/// Diffuse colour as a function of the position on a solid, so that it is the same from every view.
struct Pattern {
  enum class Kind { solid, checker, stripes, dots };
  Kind kind = Kind::solid;
  Mesh::Rgb first{200, 200, 200}, second{120, 120, 120};
  double period = 0.2;  ///< metres from one repetition to the next
};

/// A solid about its own origin.
struct Primitive {
  enum class Shape {
    half_space,  ///< local z ≤ 0, its surface is the plane z = 0
    sphere,      ///< size.x = radius
    box,         ///< size = half extents
    cylinder,    ///< about local z with caps; size.x = radius, size.z = half height
  };
  Shape shape = Shape::sphere;
  Eigen::Vector3d size = Eigen::Vector3d::Ones();  ///< metres
  SE3 world_from_local;
  Pattern pattern;
};

/// Half-space below the plane through `point` with the outward `normal` (any length).
Primitive plane(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, const Pattern& pattern = {});
Primitive sphere(const Eigen::Vector3d& center, double radius, const Pattern& pattern = {});
Primitive box(const SE3& world_from_box, const Eigen::Vector3d& half_extents, const Pattern& pattern = {});
Primitive cylinder(const SE3& world_from_cylinder, double radius, double half_height, const Pattern& pattern = {});

/// The first surface on a ray.
struct Hit {
  double t = 0;            ///< the point is origin + t * direction, for the direction as it was given
  Eigen::Vector3d normal;  ///< unit, world frame, out of the solid; flipped where the ray comes from within
  Mesh::Rgb color{};       ///< diffuse, unlit
  std::size_t primitive = 0;
};

/// The union of its primitives.
struct AnalyticScene {
  std::vector<Primitive> primitives;

  /// Metres to the nearest surface, negative inside a solid. Exact in free space; inside it is exact for one solid and
  /// a lower bound of the depth where solids overlap. Infinite for an empty scene.
  double signed_distance(const Eigen::Vector3d& point_world) const;
  /// Unsigned.
  double distance(const Eigen::Vector3d& point_world) const;

  /// Nearest surface with t > 0; empty where the ray meets none. The direction needs no unit length.
  std::optional<Hit> intersect(const Eigen::Vector3d& origin_world, const Eigen::Vector3d& direction_world) const;
};

/// A desk in the corner of a room, about 2.5 m across: floor, two walls, table with legs, and on and by it a box, a
/// tilted box, a sphere, a cylinder. Surfaces of every orientation are in each view of the default orbit. The walls
/// are x = −1.25 and y = −1.25; the room is open towards +x and +y.
AnalyticScene desk_corner();

/// Depth along the optical axis, rounded to readings, without noise: 0 where a ray meets nothing or the reading would
/// not fit in 16 bits. `color`: also the diffuse colour (black where there is nothing). `fy` may be negative. Throws
/// Error if the camera or the scale is not valid.
Frame render(const AnalyticScene& scene, const Pinhole& camera, const SE3& world_from_camera, Nanoseconds time = 0,
             double depth_scale = 5000, bool color = true);

/// Pose of a camera at `eye` whose axis goes through `target`, upright as seen along `up`. Throws Error if the eye is
/// the target or looks along `up`.
SE3 look_at(const Eigen::Vector3d& eye, const Eigen::Vector3d& target,
            const Eigen::Vector3d& up = Eigen::Vector3d::UnitZ());

/// A hand-held sweep: to and fro on an arc around the target, with a slow change of height and distance, and the
/// shake of a hand. The path is a function of time alone, so that fewer frames are the beginning of the same motion.
struct OrbitOptions {
  Eigen::Vector3d target{-0.45, -0.45, 0.75};  ///< metres, world
  double radius = 1.9;                         ///< metres, horizontally from the target's axis
  double height = 1.45;                        ///< metres, world z of the camera, on average
  double azimuth = 0.7853981633974483;         ///< radians, the middle of the arc, from +x towards +y
  double amplitude = 0.6;                      ///< radians to either side
  double period = 12;                          ///< seconds for one sweep to and fro
  int frames = 240;
  double rate = 30;                  ///< Hz
  double shake_translation = 0.004;  ///< metres rms along each axis
  double shake_rotation = 0.005;     ///< radians rms about each axis
  std::uint64_t seed = 1;
  Nanoseconds start = kNanosecondsPerSecond;
};

/// Throws Error if there is no frame or a rate or period is not positive.
Trajectory orbit(const OrbitOptions& options = {});

}  // namespace plumbline::sim
