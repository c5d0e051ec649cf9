// The map of the final fusion: bricks of fine voxels wherever a surface was seen. The host makes the bricks and keeps
// their table; voxels are in the backend's memory.
#pragma once

#include <cstddef>
#include <cstdint>

#include "backend/backend.h"
#include "backend/fine_fusion.h"
#include "core/device_array.h"
#include "kernels/fine_fusion.h"
#include "kernels/sparse_bricks.h"
#include "map/depth_ranges.h"
#include "plumbline/frame.h"
#include "plumbline/mesh.h"
#include "plumbline/parameters.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "tracking/live_frame.h"

namespace plumbline {

struct FineMapOptions {
  double voxel_size = 0.004;  ///< metres
  std::size_t max_bricks = 0;
  bool color = false;
  PreprocessParameters preprocess;  ///< the range of depth
};

/// σ(z) in metres: that of a structured-light sensor (Nguyen, Izadi, Lovell 2012), by which readings weigh in tracking,
/// too.
double reading_sigma(double depth);

/// Not thread-safe.
class FineMap {
 public:
  /// Metres of noise beyond which a reading only tells that space is free.
  static double max_sigma(double voxel_size);
  /// Bytes of memory for a brick, with what its mesh needs while it is extracted.
  static std::size_t bytes_per_brick(bool color);
  /// Of a surface of so many square metres.
  static double expected_bricks(double area, double voxel_size);

  /// `backend` must have the stages of the final fusion, and outlive the map. Throws Error if it has not, and
  /// std::bad_alloc.
  FineMap(const Pinhole& camera, const FineMapOptions& options, const Backend& backend);

  enum class Fused {
    yes,
    nothing,  ///< the frame has no reading in range, or is farther from the world's origin than bricks are counted
    no_room   ///< it touches more bricks than there is room for: what is there already was not changed
  };
  /// Throws Error if the frame is not of the camera's size.
  Fused fuse(const Frame& frame, const SE3& world_from_camera);

  /// World frame. Voxels that fewer readings met make no surface.
  Mesh extract_mesh(int min_readings) const;

  std::size_t bricks() const { return static_cast<std::size_t>(view_.bricks); }
  std::size_t bytes() const { return bricks() * bytes_per_brick(view_.has_color()); }

 private:
  /// From where a frame was taken, among the bricks around the camera.
  struct View {
    kernels::BrickWindow window;
    SE3 window_from_camera;
    float metres_per_reading;
  };

  void make_room(std::size_t max_bricks, bool color);
  void weigh_readings();
  /// These three: false if there is no room.
  bool make_touched_bricks(const View& view);
  bool make_bricks(const kernels::TouchedBricks& touched, const kernels::BrickWindow& window);
  bool make_brick(const kernels::VoxelPosition& position);
  void update(const View& view);

  void send_new_bricks(std::int32_t first);

  const Backend* backend_;
  const FineFusionStages* stages_;
  Pinhole camera_;
  int normal_level_;
  LiveFrame live_;
  DepthRanges ranges_;
  kernels::FusionNoise noise_;
  kernels::SparseBricks view_;   ///< in the backend's memory, without the table
  kernels::SparseBricks index_;  ///< positions and table, in the host's
  std::size_t max_bricks_;
  DeviceArray<float> distances_;
  DeviceArray<std::int32_t> evidence_, colors_, states_, x_, y_, z_, marked_, list_, keys_;
  DeviceArray<std::int32_t> host_x_, host_y_, host_z_, host_table_;
  Plane<std::int32_t> readings_;
  int frames_ = 0;
};

}  // namespace plumbline
