// The final fusion: a fine mesh of a recording along a trajectory that is known (docs/method.md §10).
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "plumbline/export.h"
#include "plumbline/mesh.h"
#include "plumbline/parameters.h"
#include "plumbline/se3.h"
#include "plumbline/sequence.h"

namespace plumbline {

/// A frame to fuse, and from where it was taken.
struct FusionFrame {
  int index = 0;  ///< in the sequence
  SE3 world_from_camera;
};

struct FusionProgress {
  int done = 0, total = 0;  ///< frames
};

struct FusionOptions {
  double detail = 0;                    ///< side of a voxel, metres; 0: by the noise at the distances seen
  std::size_t memory = 0;               ///< bytes that map and mesh may take; 0: half of what is free
  bool color = true;                    ///< where the frames have some
  PreprocessParameters preprocess;      ///< the range of depth
  int min_readings = 3;                 ///< that a voxel on the surface must have met
  double min_island = 10;               ///< smaller pieces of surface are left out: side of a square, in voxels
  std::size_t max_triangles = 0;        ///< the mesh is simplified to so many; 0: not
  double expected_area = 0;             ///< m² of surface, from a coarse mesh; 0: nobody knows
  std::string backend = "cpu";          ///< as for `make_backend`
  int threads = 0;                      ///< 0 = all cores
  std::function<bool()> stopping = {};  ///< asked before each frame
  std::function<void(const FusionProgress&)> on_progress = {};  ///< told after each frame
};

struct FusionResult {
  Mesh mesh;                          ///< world frame, metres
  double detail = 0;                  ///< metres
  int frames = 0;                     ///< that were fused
  std::size_t bricks = 0, bytes = 0;  ///< of the map
  std::size_t islands = 0;            ///< pieces of surface that were left out
  std::vector<std::string> notes;     ///< what the user should know, a sentence each
};

/// Fuses the frames of the sequence at their poses into voxels of `detail`, which are made where a surface is, and
/// extracts the mesh. The result has the same bits for any number of threads. Frames that cannot be read are left out
/// and noted; voxels become larger, which is noted, if the memory does not suffice. Nothing once `stopping` returns
/// true, or if no frame could be fused. Throws Error for options out of range, std::bad_alloc if the system has less
/// memory than was promised.
PLUMBLINE_EXPORT std::optional<FusionResult> fuse_frames(const Sequence& sequence,
                                                         const std::vector<FusionFrame>& frames,
                                                         const FusionOptions& options = {});

}  // namespace plumbline
