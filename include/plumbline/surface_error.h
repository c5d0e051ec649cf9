// Distances of a reconstructed surface to a reference surface, and the scores derived from them.
//
// Accuracy, completeness and the F-score at a threshold as in Knapitsch, Park, Zhou, Koltun, "Tanks and Temples", 2017.
// Everything is in metres and in one world frame: aligning the two surfaces is the caller's business.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "plumbline/export.h"
#include "plumbline/frame.h"
#include "plumbline/mesh.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "plumbline/statistics.h"

namespace plumbline::eval {

using PointCloud = std::vector<Mesh::Float3>;  ///< metres, world frame

/// The readings of every `step`-th row and column as points. Throws Error if the frame's size is not the camera's.
PLUMBLINE_EXPORT PointCloud back_project(const Frame& frame, const Pinhole& camera, const SE3& world_from_camera,
                                         int step = 1);

/// Points spread uniformly by area over the mesh's triangles. Throws Error if the mesh has no area or bad indices.
PLUMBLINE_EXPORT PointCloud sample_surface(const Mesh& mesh, std::size_t count, std::uint64_t seed = 1);

/// Metres from each point to the nearest reference point. Throws Error if there is no reference or a point is not
/// finite.
PLUMBLINE_EXPORT std::vector<double> distances_to_points(std::span<const Mesh::Float3> points,
                                                         std::span<const Mesh::Float3> reference);

/// Metres from each point to the nearest point of the reference's triangles. Throws Error if it has none, or bad
/// indices, or a point is not finite.
PLUMBLINE_EXPORT std::vector<double> distances_to_mesh(std::span<const Mesh::Float3> points, const Mesh& reference);

/// Fractions in [0, 1] at one threshold.
struct SurfaceScore {
  double threshold = 0;  ///< metres
  double precision = 0;  ///< of the reconstruction's points that lie within the threshold of the reference
  double recall = 0;     ///< of the reference's points that lie within the threshold of the reconstruction
  double f_score = 0;    ///< their harmonic mean
};

struct SurfaceError {
  Statistics accuracy;      ///< metres, reconstruction to reference
  Statistics completeness;  ///< metres, reference to reconstruction
  std::vector<SurfaceScore> scores;
};

/// Summary of the two sets of distances (metres). Throws Error if either is empty or a threshold is not positive.
PLUMBLINE_EXPORT SurfaceError surface_error(std::span<const double> to_reference,
                                            std::span<const double> from_reference, std::span<const double> thresholds);

/// Both directions for two meshes, by `samples` points on each and exact distances to the other's triangles.
PLUMBLINE_EXPORT SurfaceError compare_meshes(const Mesh& reconstruction, const Mesh& reference,
                                             std::span<const double> thresholds, std::size_t samples = 200'000,
                                             std::uint64_t seed = 1);

/// Both directions for two point clouds.
PLUMBLINE_EXPORT SurfaceError compare_points(std::span<const Mesh::Float3> reconstruction,
                                             std::span<const Mesh::Float3> reference,
                                             std::span<const double> thresholds);

}  // namespace plumbline::eval
