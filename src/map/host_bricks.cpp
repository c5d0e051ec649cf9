#include "map/host_bricks.h"

#include <algorithm>
#include <bit>
#include <numeric>

#include "backend/backend.h"
#include "backend/fine_fusion.h"
#include "kernels/voxel.h"
#include "map/mesh_of_bricks.h"
#include "plumbline/backend.h"

namespace plumbline {

HostBricks::HostBricks(double voxel_size, bool with_color) : voxel_size_(voxel_size), with_color_(with_color) {}

void HostBricks::add(const kernels::VoxelPosition& position, const BrickWords& words, double truncation,
                     int min_weight) {
  const std::size_t first = distances_.size();
  distances_.resize(first + words.voxels.size());
  evidence_.resize(first + words.voxels.size());
  for (std::size_t i = 0; i < words.voxels.size(); ++i) {
    const kernels::Voxel<float> voxel = kernels::unpack<float>(words.voxels[i]);
    const bool is_seen = voxel.weight >= static_cast<float>(min_weight);
    distances_[first + i] = voxel.distance * static_cast<float>(truncation);
    evidence_[first + i] = is_seen ? kernels::Evidence<float>{voxel.weight, 1, 0}.pack() : 0;
  }
  if (with_color_) colors_.insert(colors_.end(), words.colors.begin(), words.colors.end());
  states_.push_back(words.state);
  x_.push_back(position.x);
  y_.push_back(position.y);
  z_.push_back(position.z);
  max_step_ = 2 * truncation;  // no two distances differ by more: every change of sign is a surface
}

kernels::SparseBricks HostBricks::view_of_all() {
  table_.assign(std::bit_ceil(2 * states_.size() + 1), 0);
  kernels::SparseBricks view;
  view.voxel_size = static_cast<float>(voxel_size_);
  view.max_through = 1;
  view.max_step = static_cast<float>(max_step_);
  view.distances = distances_.data();
  view.evidence = evidence_.data();
  view.colors = with_color_ ? colors_.data() : nullptr;
  view.states = states_.data();
  view.x = x_.data();
  view.y = y_.data();
  view.z = z_.data();
  view.table = table_.data();
  view.table_mask = static_cast<std::uint32_t>(table_.size() - 1);
  for (std::size_t i = 0; i < states_.size(); ++i) view.make_brick({x_[i], y_[i], z_[i]});
  return view;
}

Mesh HostBricks::extract_mesh() {
  const int all = static_cast<int>(states_.size());
  return extract_mesh(*make_backend("cpu"), all, all);
}

Mesh HostBricks::extract_mesh(const Backend& host, int own, int listed) {
  const kernels::SparseBricks view = view_of_all();
  std::vector<std::int32_t> every(states_.size());
  std::iota(every.begin(), every.end(), 0);
  return mesh_of_bricks(host, *host.fine_fusion(), view, {every.data(), every.data(), listed, own}, 1);
}

}  // namespace plumbline
