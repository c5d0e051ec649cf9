// Recordings of made-up scenes, with exact truth.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "plumbline/angles.h"
#include "plumbline/export.h"
#include "plumbline/mesh.h"
#include "plumbline/pinhole.h"
#include "plumbline/trajectory.h"

namespace plumbline {

struct SimulateOptions {
  std::string scene = "desk";  ///< one of `scene_names()`, or a PLY or OBJ file (metres, z up)
  std::string path = "orbit";  ///< one of `path_names()`, or a trajectory in TUM's format
  int frames = 0;              ///< at most; 0: the whole path
  double rate = 30;            ///< frames a second
  double speed = 1;            ///< how much faster than it is the path is played
  double duration = 8;         ///< seconds, of a made-up path
  Pinhole camera{525, 525, 319.5f, 239.5f, 640, 480};
  bool noise = true;  ///< false: exact depth
  bool color = true;
  double tilt_error = radians(3), heading_error = radians(10);  ///< radians: the sensor's systematic error
  std::uint64_t seed = 1;                                       ///< of everything random
};

struct Simulation {
  Trajectory world_from_camera;  ///< the truth, a pose a frame
  Mesh scene;                    ///< the true surface, world frame
};

/// Writes a folder that `open_sequence` reads: depth, colour, camera.json, groundtruth.txt, orientation.txt, imu.csv,
/// scene.ply and scene.toml. The same bytes for the same options, and those of `plumbline simulate`. Throws Error for
/// unknown names, values out of range, and files that cannot be written.
PLUMBLINE_EXPORT Simulation simulate(const std::string& folder, const SimulateOptions& options = {});

PLUMBLINE_EXPORT std::vector<std::string> scene_names();
PLUMBLINE_EXPORT std::vector<std::string> path_names();

}  // namespace plumbline
