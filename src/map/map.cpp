#include "plumbline/map.h"

#include <vector>

#include "kernels/voxel.h"
#include "map/volume.h"

namespace plumbline {

Map Volume::extract_map() const {
  const Backend& backend = *backend_;
  const DeviceArray<std::int32_t> list(backend, static_cast<std::size_t>(view_.slots()));
  const int entries = backend.compact(view_.states(), view_.slots(), list.data());
  Map map;
  map.voxel_size = voxel_size();
  map.truncation = view_.truncation;
  map.world_from_map = world_from_volume_;
  std::vector<std::int32_t> words(Map::kBrickVoxels);
  for (const std::int32_t brick : list.download(backend, static_cast<std::size_t>(entries))) {
    const kernels::VoxelPosition origin = view_.origin_of(brick);
    map.bricks.push_back({origin.x, origin.y, origin.z});
    backend.download(words.data(), view_.voxels_of(brick), words.size() * sizeof(words[0]));
    for (const std::int32_t word : words) {
      const kernels::Voxel<float> voxel = kernels::unpack<float>(word);
      map.distances.push_back(voxel.distance * view_.truncation);
      map.weights.push_back(static_cast<std::uint16_t>(voxel.weight));
    }
  }
  return map;
}

}  // namespace plumbline
