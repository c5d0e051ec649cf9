// The views of a recording that loops are closed by: frames along its path, each with a code to find it by and a coarse
// depth image to register to.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "backend/maps.h"
#include "place/ferns.h"
#include "plumbline/image.h"
#include "plumbline/parameters.h"
#include "plumbline/se3.h"
#include "plumbline/sequence.h"

namespace plumbline {

/// A frame of a recording as it was tracked.
struct PathFrame {
  int index = 0;  ///< in the sequence
  SE3 world_from_camera;
  bool is_cut = false;                     ///< nothing but the map links it to the frame before
  std::optional<Eigen::Vector3d> up = {};  ///< by a sensor, in the camera's axes
};

/// One of them that was kept.
struct PathView {
  std::size_t frame = 0;  ///< of the path
  SE3 world_from_camera;
  double travelled = 0;  ///< since the path's beginning, as pose_distance has it: radians, 1.5 m as one
  int piece = 0;         ///< of the path between two cuts
  std::optional<Eigen::Vector3d> up;
  FernCode code;
  Image<float> depth;  ///< metres, of the finest level that is tracked
};

/// Of the path, the frames that are a step apart, the ends of its pieces among them; `step` in radians, 1.5 m as one.
std::vector<std::size_t> spaced_frames(const std::vector<PathFrame>& path, double step);

/// Those frames, read and prepared as they were for tracking. Frames that cannot be read are left out. Nothing once
/// `stopping` returns true.
std::vector<PathView> read_views(const Sequence& recording, const std::vector<PathFrame>& path,
                                 const std::vector<std::size_t>& chosen, const Parameters& parameters,
                                 const Backend& backend, const std::function<bool()>& stopping);

}  // namespace plumbline
