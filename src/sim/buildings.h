// Scenes that one walks through, and comes back in: corridors and rooms with open doors between them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "plumbline/mesh.h"

namespace plumbline::sim {

/// A mesh (metres, world, z up) and the way through it: points on the floor, in the order in which they are passed.
struct Building {
  Mesh mesh;
  std::vector<Eigen::Vector2d> way;
};

/// A corridor 2 m wide around a square block, 44 m along its middle; the way goes round once and 6 m beyond its start.
Building ring_corridor();

/// Six rooms of 6.5 m × 6.4 m at both sides of a corridor, 300 m² together; the way visits all of them, comes back
/// along the corridor and enters the first again. Rooms with the same key are furnished alike: those across the
/// corridor are then each other's image turned by 180°, those on one side moved by the width of a room.
Building floor_of_rooms(const std::array<std::uint64_t, 6>& keys);

}  // namespace plumbline::sim
