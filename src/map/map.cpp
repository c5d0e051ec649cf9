#include "plumbline/map.h"

#include <algorithm>
#include <vector>

#include "kernels/voxel.h"
#include "map/volume.h"

namespace plumbline {
namespace {

/// Slots of the bricks that hold or held a surface, ascending.
std::vector<std::int32_t> occupied_slots(const Backend& backend, const kernels::BrickMap& map) {
  const DeviceArray<std::int32_t> list(backend, static_cast<std::size_t>(map.slots()));
  const int entries = backend.compact(map.states(), map.slots(), list.data());
  return list.download(backend, static_cast<std::size_t>(entries));
}

}  // namespace

kernels::VoxelPosition Volume::position_of(std::int32_t slot) const {
  const kernels::VoxelPosition in_window = kernels::brick_of(view_.origin_of(slot));
  return {first_brick_.x + in_window.x, first_brick_.y + in_window.y, first_brick_.z + in_window.z};
}

BrickWords Volume::words_of(std::int32_t slot) const {
  BrickWords words;
  constexpr std::size_t kBytes = sizeof(words.voxels);
  backend_->download(words.voxels.data(), view_.voxels_of(slot), kBytes);
  if (view_.has_color()) backend_->download(words.colors.data(), view_.colors_of(slot), kBytes);
  backend_->download(&words.state, view_.states() + slot, sizeof(words.state));
  return words;
}

/// A place that was mapped twice counts as it was mapped last.
void Volume::visit_bricks(const BrickVisitor& visit) const {
  for (const BrickKey key : bricks_with_surface()) {
    const kernels::VoxelPosition position = position_of_key(key);
    visit(position, words_at(position));
  }
}

std::vector<BrickKey> Volume::keys_of(const std::vector<std::int32_t>& slots) const {
  std::vector<BrickKey> keys;
  keys.reserve(slots.size());
  for (const std::int32_t slot : slots) keys.push_back(key_of(position_of(slot)));
  return keys;
}

std::vector<BrickKey> Volume::bricks_with_surface() const {
  std::vector<BrickKey> keys = keys_of(occupied_slots(*backend_, view_));
  std::vector<BrickKey> in_window = keys;
  std::sort(in_window.begin(), in_window.end());
  for (const kernels::VoxelPosition& position : packed_.positions()) {
    const BrickKey key = key_of(position);
    if (!std::binary_search(in_window.begin(), in_window.end(), key)) keys.push_back(key);
  }
  return keys;
}

std::vector<BrickKey> Volume::updated_bricks() const {
  return keys_of(list_.download(*backend_, static_cast<std::size_t>(bricks_updated())));
}

/// A brick that is nowhere, as the volume was placed anew, has nothing but zeros.
BrickWords Volume::words_at(const kernels::VoxelPosition& position) const {
  const kernels::VoxelPosition in_window = {position.x - first_brick_.x, position.y - first_brick_.y,
                                            position.z - first_brick_.z};
  const BrickWords words = view_.has_brick(in_window) ? words_of(view_.slot_of(in_window)) : BrickWords();
  return words.state == 0 && packed_.contains(position) ? packed_.unpack_latest(position) : words;
}

MapUpdate Volume::copy_bricks(const std::vector<BrickKey>& bricks) const {
  MapUpdate update;
  update.voxel_size = voxel_size();
  update.truncation = view_.truncation;
  update.world_from_map = world_from_volume_;
  for (const BrickKey key : bricks) {
    const kernels::VoxelPosition position = position_of_key(key), lowest = kernels::first_voxel_of(position);
    const BrickWords words = words_at(position);
    update.bricks.push_back({lowest.x, lowest.y, lowest.z});
    update.voxels.insert(update.voxels.end(), words.voxels.begin(), words.voxels.end());
    if (view_.has_color()) update.colors.insert(update.colors.end(), words.colors.begin(), words.colors.end());
  }
  return update;
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
