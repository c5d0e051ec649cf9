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

bool is_zero(const VoxelPosition& p) { return p.x == 0 && p.y == 0 && p.z == 0; }
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

double Volume::follow(const Viewpoint& from) {
  if (parameters_.placement != VolumePlacement::follow) return from.travelled;
  take_back_borrowed(from.travelled);
  const VoxelPosition by = wanted_move(from.world_from_camera), previous_first = first_brick_;
  if (!is_zero(by)) move_window(by);  // what leaves was made before the camera came to another place
  // Where the window comes back from a visit, or goes on in another part of the map, the camera has not moved so far.
  const bool is_on_its_way = !is_visiting_ && from.travelled == travelled_;
  is_visiting_ = false;
  travelled_ = from.travelled;
  if (is_zero(by)) return travelled_;
  std::vector<PackedBrick> bricks = entering(previous_first, travelled_);
  std::erase_if(bricks, [&](const PackedBrick& brick) { return !are_consistent(brick.travelled, travelled_); });
  unpack(bricks);
  if (is_on_its_way) travelled_ += double{view_.brick_size()} * Eigen::Vector3d(by.x, by.y, by.z).norm();
  return travelled_;
}

void Volume::visit(const Viewpoint& from) {
  if (parameters_.placement != VolumePlacement::follow) return;
  const VoxelPosition by = wanted_move(from.world_from_camera), previous_first = first_brick_;
  if (is_zero(by)) return;
  is_visiting_ = true;
  move_window(by);
  const std::vector<PackedBrick> bricks = entering(previous_first, from.travelled);
  for (const PackedBrick& brick : bricks) borrowed_[key_of(brick.position)] = brick.travelled;
  unpack(bricks);
}

VoxelPosition Volume::wanted_move(const SE3& world_from_camera) const {
  const Eigen::Vector3d wanted =
      world_from_window_.inverse() * (world_from_camera * Eigen::Vector3d(0, 0, (parameters_.offset + 0.5) * side()));
  const auto along = [&](int axis) {
    const double off = wanted[axis] - 0.5 * side();
    return std::abs(off) > kMaxOffset * side() ? static_cast<int>(std::lround(off / double{view_.brick_size()})) : 0;
  };
  return {along(0), along(1), along(2)};
}

void Volume::move_window(const VoxelPosition& by) {
  pack_leaving(by);
  view_.move(by);
  first_brick_ = sum(first_brick_, by);
  const double size = double{view_.brick_size()};
  world_from_window_ = world_from_volume_ * SE3(Eigen::Matrix3d::Identity(),
                                                size * Eigen::Vector3d(first_brick_.x, first_brick_.y, first_brick_.z));
}

/// What a visit brought into the window stays there only if the camera went on from the place visited.
void Volume::take_back_borrowed(double travelled) {
  std::vector<std::int32_t> slots;
  for (const auto& [key, made_at] : borrowed_)
    if (!are_consistent(made_at, travelled))
      slots.push_back(view_.slot_of(difference(position_of_key(key), first_brick_)));
  if (!slots.empty()) pack(DeviceArray<std::int32_t>(*backend_, slots), slots);
  borrowed_.clear();
}

void Volume::pack_leaving(const VoxelPosition& by) {
  backend_->run(kernels::MarkLeavingBricks{view_, by, marked_.data()});
  const auto leaving = static_cast<std::size_t>(backend_->compact(marked_.data(), view_.slots(), list_.data()));
  pack(list_, list_.download(*backend_, leaving));
}

/// `list`: the slots, in the backend's memory.
void Volume::pack(const DeviceArray<std::int32_t>& list, const std::vector<std::int32_t>& slots) {
  const Copies copies(*backend_, std::min(slots.size(), kBricksAtOnce), view_.has_color());
  for (std::size_t first = 0; first < slots.size(); first += kBricksAtOnce) {
    const std::size_t count = std::min(slots.size() - first, kBricksAtOnce);
    backend_->run(kernels::TakeBrick{view_, list.data() + first, copies.view()}, static_cast<int>(count));
    const std::vector<std::int32_t> voxels = copies.voxels.download(*backend_, count * kernels::kBrickVoxels);
    const std::vector<std::int32_t> colors =
        copies.colors.download(*backend_, view_.has_color() ? count * kernels::kBrickVoxels : 0);
    const std::vector<std::int32_t> states = copies.states.download(*backend_, count);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t word = i * kernels::kBrickVoxels;
      const VoxelPosition position = position_of(slots[first + i]);
      const auto borrowed = borrowed_.extract(key_of(position));
      packed_.keep(position, borrowed.empty() ? travelled_ : borrowed.mapped(), states[i], voxels.data() + word,
                   view_.has_color() ? colors.data() + word : nullptr);
    }
  }
}

bool Volume::is_in_window(const VoxelPosition& position, const VoxelPosition& first_brick) const {
  return view_.has_brick(difference(position, first_brick));
}

std::vector<Volume::PackedBrick> Volume::entering(const VoxelPosition& previous_first, double travelled) const {
  std::vector<PackedBrick> bricks;
  for (const VoxelPosition& position : packed_.positions_in(first_brick_, view_.bricks_per_row()))
    if (!is_in_window(position, previous_first)) bricks.push_back({position, packed_.nearest(position, travelled)});
  return bricks;
}

void Volume::unpack(const std::vector<PackedBrick>& bricks) {
  for (std::size_t first = 0; first < bricks.size(); first += kBricksAtOnce) {
    const std::size_t end = std::min(first + kBricksAtOnce, bricks.size());
    std::vector<std::int32_t> slots, states, voxels, colors;
    for (std::size_t i = first; i < end; ++i) {
      const auto& [position, travelled] = bricks[i];
      const BrickWords brick = packed_.unpack(position, travelled);
      slots.push_back(view_.slot_of(difference(position, first_brick_)));
      states.push_back(brick.state);
      voxels.insert(voxels.end(), brick.voxels.begin(), brick.voxels.end());
      if (view_.has_color()) colors.insert(colors.end(), brick.colors.begin(), brick.colors.end());
      packed_.remove(position, travelled);
    }
    const DeviceArray<std::int32_t> list(*backend_, slots),
        on_device[] = {{*backend_, voxels}, {*backend_, colors}, {*backend_, states}};
    backend_->run(
        kernels::PutBrick{view_, list.data(), {on_device[0].data(), on_device[1].data(), on_device[2].data()}},
        static_cast<int>(slots.size()));
  }
}

}  // namespace plumbline
