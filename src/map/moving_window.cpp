// The volume's window follows the camera (docs/method.md §6.5); what it leaves is packed.
#include <algorithm>
#include <cmath>
#include <vector>

#include "map/volume.h"

namespace plumbline {
namespace {

using kernels::VoxelPosition;

// Of the window's side: as far as the camera may get from where it is wanted before the window moves.
constexpr double kMaxOffset = 1.0 / 8;
// Copied between the device and the host at once.
constexpr std::size_t kBricksAtOnce = 2048;

VoxelPosition sum(const VoxelPosition& a, const VoxelPosition& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
VoxelPosition difference(const VoxelPosition& a, const VoxelPosition& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }

/// Copies of bricks in the device's memory.
struct Copies {
  DeviceArray<std::int32_t> voxels, colors, states;

  Copies(const Backend& backend, std::size_t bricks, bool with_color)
      : voxels(backend, bricks * kernels::kBrickVoxels),
        colors(backend, with_color ? bricks * kernels::kBrickVoxels : 0),
        states(backend, bricks) {}
  kernels::BrickCopies view() const { return {voxels.data(), colors.data(), states.data()}; }
};

}  // namespace

void Volume::follow(const SE3& world_from_camera) {
  if (parameters_.placement != VolumePlacement::follow) return;
  const Eigen::Vector3d wanted =
      world_from_window_.inverse() * (world_from_camera * Eigen::Vector3d(0, 0, (parameters_.offset + 0.5) * side()));
  const auto along = [&](int axis) {
    const double off = wanted[axis] - 0.5 * side();
    return std::abs(off) > kMaxOffset * side() ? static_cast<int>(std::lround(off / double{view_.brick_size()})) : 0;
  };
  const VoxelPosition by = {along(0), along(1), along(2)};
  if (by.x != 0 || by.y != 0 || by.z != 0) move_window(by);
}

void Volume::move_window(const VoxelPosition& by) {
  pack_leaving(by);
  view_.move(by);
  first_brick_ = sum(first_brick_, by);
  const double size = double{view_.brick_size()};
  world_from_window_ = world_from_volume_ * SE3(Eigen::Matrix3d::Identity(),
                                                size * Eigen::Vector3d(first_brick_.x, first_brick_.y, first_brick_.z));
  unpack_entering();
}

void Volume::pack_leaving(const VoxelPosition& by) {
  backend_->run(kernels::MarkLeavingBricks{view_, by, marked_.data()});
  const auto leaving = static_cast<std::size_t>(backend_->compact(marked_.data(), view_.slots(), list_.data()));
  const std::vector<std::int32_t> slots = list_.download(*backend_, leaving);
  const Copies copies(*backend_, std::min(leaving, kBricksAtOnce), view_.has_color());
  for (std::size_t first = 0; first < leaving; first += kBricksAtOnce) {
    const std::size_t count = std::min(leaving - first, kBricksAtOnce);
    backend_->run(kernels::TakeBrick{view_, list_.data() + first, copies.view()}, static_cast<int>(count));
    const std::vector<std::int32_t> voxels = copies.voxels.download(*backend_, count * kernels::kBrickVoxels);
    const std::vector<std::int32_t> colors =
        copies.colors.download(*backend_, view_.has_color() ? count * kernels::kBrickVoxels : 0);
    const std::vector<std::int32_t> states = copies.states.download(*backend_, count);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t word = i * kernels::kBrickVoxels;
      packed_.keep(position_of(slots[first + i]), states[i], voxels.data() + word,
                   view_.has_color() ? colors.data() + word : nullptr);
    }
  }
}

void Volume::unpack_entering() {
  const std::vector<VoxelPosition> entering = packed_.positions_in(first_brick_, view_.bricks_per_row());
  for (std::size_t first = 0; first < entering.size(); first += kBricksAtOnce) {
    const std::size_t end = std::min(first + kBricksAtOnce, entering.size());
    std::vector<std::int32_t> slots, states, voxels, colors;
    for (std::size_t i = first; i < end; ++i) {
      const BrickWords brick = packed_.unpack(entering[i]);
      slots.push_back(view_.slot_of(difference(entering[i], first_brick_)));
      states.push_back(brick.state);
      voxels.insert(voxels.end(), brick.voxels.begin(), brick.voxels.end());
      if (view_.has_color()) colors.insert(colors.end(), brick.colors.begin(), brick.colors.end());
      packed_.remove(entering[i]);
    }
    const DeviceArray<std::int32_t> list(*backend_, slots),
        on_device[] = {{*backend_, voxels}, {*backend_, colors}, {*backend_, states}};
    backend_->run(
        kernels::PutBrick{view_, list.data(), {on_device[0].data(), on_device[1].data(), on_device[2].data()}},
        static_cast<int>(slots.size()));
  }
}

}  // namespace plumbline
