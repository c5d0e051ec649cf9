// The model: a truncated signed distance volume that frames are fused into, predicted from and meshed.
#pragma once

#include <functional>
#include <map>
#include <vector>

#include "backend/maps.h"
#include "core/device_array.h"
#include "core/viewpoint.h"
#include "kernels/brick_map.h"
#include "map/depth_ranges.h"
#include "map/packed_bricks.h"
#include "plumbline/image.h"
#include "plumbline/map.h"
#include "plumbline/mesh.h"
#include "plumbline/parameters.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"

namespace plumbline {

/// Where the volume goes: the lower corner's pose, and the length of a side.
struct VolumePlacementResult {
  SE3 world_from_volume;
  double side = 0;  ///< metres
};

/// Volume placed by the parameters, given the first camera and its depth in metres (row-major, zeros for none).
VolumePlacementResult place_volume(const VolumeParameters& parameters, const Pinhole& camera,
                                   const SE3& world_from_camera, const Image<float>& depth);

/// Where surfaces are predicted, metres from the camera along its optical axis.
struct RaycastRange {
  double min_distance = 0.05;
  double max_distance = 10;
};

/// As far as a camera with this `max_depth` reads, and 10 m in any case: what lies in the volume behind the readings is
/// predicted too.
inline RaycastRange raycast_range(double max_depth) {
  RaycastRange range;
  range.max_distance = max_depth > range.max_distance ? max_depth : range.max_distance;
  return range;
}

/// A cube of voxels in a backend's memory, allocated once: all of the map, or, where it is to follow the camera, a
/// window on a map without an end.
class Volume {
 public:
  /// Throws std::bad_alloc if the memory is not there. `backend` must outlive the volume.
  Volume(const VolumeParameters& parameters, const Pinhole& camera, const Backend& backend, bool with_color);

  /// Sets pose and size; what was fused before is forgotten.
  void place(const VolumePlacementResult& placement);

  /// With the placement `follow`: moves the window where the camera leaves its middle. Bricks that leave it are packed;
  /// those that are known there are unpacked, if they are consistent with where the camera comes from: after a long way
  /// the place is mapped anew. Returns what the window has travelled then. Otherwise does nothing.
  double follow(const Viewpoint& from);
  /// The same for a look from where no frame is fused: what is known there, of several bricks that which was made
  /// nearest to the viewpoint's `travelled`. The next `follow` takes back what is not consistent with it.
  void visit(const Viewpoint& from);

  /// Fuses a depth image (metres) and, if not null, its colours, seen from `world_from_camera`.
  void integrate(const Plane<float>& depth, const Plane<std::int32_t>* color, const Pinhole& camera,
                 const SE3& world_from_camera);

  /// Predicts depth and normals at every level of `model`.
  void predict(const SE3& world_from_camera, const RaycastRange& range, DepthPyramid* model) const;

  /// The surface, that outside the window included, world frame. Colours when the volume has them. Empty when nothing
  /// was fused.
  Mesh extract_mesh(const MeshParameters& parameters) const;
  /// The voxels of all bricks that hold or held a surface, inside the window and outside.
  Map extract_map() const;

  /// Bricks by `key_of`: those that hold or held a surface, inside the window and outside.
  std::vector<BrickKey> bricks_with_surface() const;
  /// Those that the latest frame updated.
  std::vector<BrickKey> updated_bricks() const;
  MapUpdate copy_bricks(const std::vector<BrickKey>& bricks) const;

  const SE3& world_from_volume() const {
    return world_from_volume_;
  }  ///< as placed; where the window has moved, its first place
  const SE3& world_from_window() const { return world_from_window_; }
  std::size_t packed_bricks() const { return packed_.size(); }
  double side() const { return view_.voxel_size * static_cast<double>(view_.resolution()); }
  double voxel_size() const { return view_.voxel_size; }
  int bricks_updated() const;  ///< by the latest frame
  const kernels::BrickMap& view() const { return view_; }

 private:
  /// Counted in bricks.
  kernels::VoxelPosition wanted_move(const SE3& world_from_camera) const;
  void move_window(const kernels::VoxelPosition& by);
  void pack_leaving(const kernels::VoxelPosition& by);
  void pack(const DeviceArray<std::int32_t>& list, const std::vector<std::int32_t>& slots);
  void take_back_borrowed(double travelled);
  /// A packed brick by its name.
  struct PackedBrick {
    kernels::VoxelPosition position;
    double travelled;
  };
  /// Those that the window holds now, but did not hold with this lowest brick.
  std::vector<PackedBrick> entering(const kernels::VoxelPosition& previous_first, double travelled) const;
  void unpack(const std::vector<PackedBrick>& bricks);
  bool is_in_window(const kernels::VoxelPosition& position, const kernels::VoxelPosition& first_brick) const;
  /// Of every brick that holds or held a surface, its position counted in bricks from the volume's lowest one.
  using BrickVisitor = std::function<void(const kernels::VoxelPosition&, const BrickWords&)>;
  void visit_bricks(const BrickVisitor& visit) const;
  /// Counted in bricks from the volume's lowest one, of a brick in the window.
  kernels::VoxelPosition position_of(std::int32_t slot) const;
  std::vector<BrickKey> keys_of(const std::vector<std::int32_t>& slots) const;
  BrickWords words_of(std::int32_t slot) const;
  BrickWords words_at(const kernels::VoxelPosition& position) const;
  Mesh mesh_of_window(int min_weight) const;
  Mesh mesh_of_all(int min_weight) const;
  kernels::RaySpanView span_rays(const SE3& world_from_camera, const Pinhole& camera, float min_distance) const;

  const Backend* backend_;
  VolumeParameters parameters_;
  DepthRanges ranges_;
  SE3 world_from_volume_, world_from_window_;
  kernels::VoxelPosition first_brick_ = {0, 0, 0};  ///< the window's lowest, counted in bricks from the volume's
  PackedBricks packed_;                             ///< outside the window, or made long before what is in it
  std::map<BrickKey, double> borrowed_;             ///< `travelled` of bricks that a visit brought into the window
  double travelled_ = 0;                            ///< by the window, by the latest `follow`
  bool is_visiting_ = false;                        ///< whether a visit has moved the window since
  kernels::BrickMap view_;
  DeviceArray<std::int32_t> voxels_, colors_, states_, marked_, list_, listed_;
  mutable DeviceArray<float> spans_;  ///< of the previous prediction's rays; scratch
  int frames_ = 0;
};

}  // namespace plumbline
