#include "plumbline/map.h"

#include <vector>

#include "kernels/voxel.h"
#include "map/volume.h"

namespace plumbline {

void Volume::visit_bricks(const BrickVisitor& visit) const {
  const Backend& backend = *backend_;
  const DeviceArray<std::int32_t> list(backend, static_cast<std::size_t>(view_.slots()));
  const int entries = backend.compact(view_.states(), view_.slots(), list.data());
  BrickWords words;
  const std::size_t bytes = sizeof(words.voxels);
  for (const std::int32_t brick : list.download(backend, static_cast<std::size_t>(entries))) {
    backend.download(words.voxels.data(), view_.voxels_of(brick), bytes);
    if (view_.has_color()) backend.download(words.colors.data(), view_.colors_of(brick), bytes);
    backend.download(&words.state, view_.states() + brick, sizeof(words.state));
    const kernels::VoxelPosition in_window = kernels::brick_of(view_.origin_of(brick));
    visit({first_brick_.x + in_window.x, first_brick_.y + in_window.y, first_brick_.z + in_window.z}, words);
  }
  for (const kernels::VoxelPosition& position : packed_.positions()) visit(position, packed_.unpack(position));
}

Map Volume::extract_map() const {
  Map map;
  map.voxel_size = voxel_size();
  map.truncation = view_.truncation;
  map.world_from_map = world_from_volume_;
  visit_bricks([&](const kernels::VoxelPosition& position, const BrickWords& words) {
    const kernels::VoxelPosition lowest = kernels::first_voxel_of(position);
    map.bricks.push_back({lowest.x, lowest.y, lowest.z});
    for (const std::int32_t word : words.voxels) {
      const kernels::Voxel<float> voxel = kernels::unpack<float>(word);
      map.distances.push_back(voxel.distance * view_.truncation);
      map.weights.push_back(static_cast<std::uint16_t>(voxel.weight));
    }
  });
  return map;
}

}  // namespace plumbline
