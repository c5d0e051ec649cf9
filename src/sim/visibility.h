// Which points of a scene a camera has seen.
#pragma once

#include <span>
#include <vector>

#include "plumbline/mesh.h"
#include "plumbline/pinhole.h"
#include "plumbline/trajectory.h"

namespace plumbline::sim {

/// True for each point that lies in the image of one of the poses, at a depth within the range (metres), with no
/// surface of the mesh between. Throws Error if the camera is not valid or a triangle names a vertex that is not there.
std::vector<bool> seen_points(const Mesh& mesh, std::span<const Mesh::Float3> points, const Pinhole& camera,
                              const Trajectory& poses, double min_depth, double max_depth);

}  // namespace plumbline::sim
