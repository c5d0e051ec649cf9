// The volume's surface as a mesh on the host.
#include <algorithm>
#include <vector>

#include "map/host_bricks.h"
#include "map/mesh_of_bricks.h"
#include "map/volume.h"
#include "plumbline/mesh.h"
#include "plumbline/se3.h"

namespace plumbline {

Mesh Volume::extract_mesh(const MeshParameters& parameters) const {
  // Never more than a voxel can have: that of a short run, or of a low cap.
  const int min_weight = std::min({std::max(frames_, 1), parameters.min_weight, parameters_.max_weight});
  return packed_.empty() ? mesh_of_window(min_weight) : mesh_of_all(min_weight);
}

Mesh Volume::mesh_of_window(int min_weight) const {
  const Backend& backend = *backend_;
  const int slots = view_.slots();
  DeviceArray<std::int32_t> list(backend, static_cast<std::size_t>(slots));
  const int entries = backend.compact(view_.states(), slots, list.data());
  const auto count = static_cast<std::size_t>(entries);
  const DeviceArray<std::int32_t> position(
      backend, entry_of_each(list.download(backend, count), static_cast<std::size_t>(slots)));
  Mesh mesh = mesh_of_bricks(backend, backend, view_, {list.data(), position.data(), entries}, min_weight);
  transform_mesh(world_from_window_, &mesh);
  return mesh;
}

/// On the host, where the packed bricks are.
Mesh Volume::mesh_of_all(int min_weight) const {
  HostBricks bricks(voxel_size(), view_.has_color());
  visit_bricks([&](const kernels::VoxelPosition& position, const BrickWords& words) {
    bricks.add(position, words, static_cast<double>(view_.truncation), min_weight);
  });
  Mesh mesh = bricks.extract_mesh();
  transform_mesh(world_from_volume_, &mesh);
  return mesh;
}

}  // namespace plumbline
