// Places to scan, as exact meshes with vertex colours: built by code, the same on every machine.
//
// The world is in metres with z up, the floor at z = 0.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "plumbline/mesh.h"
#include "plumbline/se3.h"

namespace plumbline::sim {

struct Scene {
  std::string name;
  Mesh mesh;                              ///< metres, world; triangles face the free side
  Eigen::Vector3d focus;                  ///< metres, world: the middle of what there is to look at
  double focus_radius;                    ///< metres: most of it lies within
  std::vector<Eigen::Vector2d> way = {};  ///< through it, on the floor, where it is to be walked through; metres
};

/// desk (two desks full of things in an office), room (a living room), kitchen, teddy (one object on a floor), corridor
/// (long bare walls: what registration cannot hold on to), ring (a furnished corridor around a block), floor (six rooms
/// at a corridor), twins (the same with all rooms alike).
std::vector<std::string> scene_names();

/// Throws Error naming the known ones.
Scene make_scene(std::string_view name);

/// A mesh from elsewhere; focus and radius come from where its surface lies. Throws Error if it has no area, a vertex
/// is not finite, or a triangle names a vertex that is not there.
Scene scene_of(std::string name, Mesh mesh);

}  // namespace plumbline::sim
