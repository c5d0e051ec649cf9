// Bricks of a volume that lie outside its window, compressed in the host's memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "kernels/brick_map.h"

namespace plumbline {

/// One brick as the volume keeps it.
struct BrickWords {
  std::int32_t state = 0;
  std::array<std::int32_t, kernels::kBrickVoxels> voxels{};
  std::array<std::int32_t, kernels::kBrickVoxels> colors{};  ///< zeros where the volume has none
};

/// A brick of the map by one number, wherever it is kept.
using BrickKey = std::int64_t;
constexpr int kBrickKeyBits = 21;  ///< an axis
inline BrickKey key_of(const kernels::VoxelPosition& p) {
  constexpr BrickKey kHalf = BrickKey{1} << (kBrickKeyBits - 1);
  return ((p.z + kHalf) << 2 * kBrickKeyBits) | ((p.y + kHalf) << kBrickKeyBits) | (p.x + kHalf);
}
inline kernels::VoxelPosition position_of_key(BrickKey key) {
  constexpr BrickKey kHalf = BrickKey{1} << (kBrickKeyBits - 1), kMask = 2 * kHalf - 1;
  const auto axis = [&](int shift) { return static_cast<std::int32_t>((key >> shift & kMask) - kHalf); };
  return {axis(0), axis(kBrickKeyBits), axis(2 * kBrickKeyBits)};
}

/// Positions are counted in bricks, in the frame of the map. A place that was mapped again after a long way has several
/// bricks, told apart by what the window had `travelled` (core/viewpoint.h). Nothing is lost by packing.
class PackedBricks {
 public:
  explicit PackedBricks(bool with_color);
  ~PackedBricks();
  PackedBricks(PackedBricks&&) noexcept;
  PackedBricks& operator=(PackedBricks&&) noexcept;

  /// `colors` may be null without colour. A brick of the same position and `travelled` is replaced. Throws
  /// std::bad_alloc.
  void keep(const kernels::VoxelPosition& position, double travelled, std::int32_t state, const std::int32_t* voxels,
            const std::int32_t* colors);
  bool contains(const kernels::VoxelPosition& position) const { return bricks_.contains(order_of(position)); }
  /// `travelled` of the position's brick that is nearest to a given one; there must be a brick.
  double nearest(const kernels::VoxelPosition& position, double travelled) const;
  /// These two: the brick must be there, with exactly this `travelled`.
  BrickWords unpack(const kernels::VoxelPosition& position, double travelled) const;
  void remove(const kernels::VoxelPosition& position, double travelled);
  /// The brick that was left latest; there must be one.
  BrickWords unpack_latest(const kernels::VoxelPosition& position) const;

  /// Of all bricks, ordered by z, y, x, each once.
  std::vector<kernels::VoxelPosition> positions() const;
  /// Of those in a cube with this lowest corner, in the same order.
  std::vector<kernels::VoxelPosition> positions_in(const kernels::VoxelPosition& lowest, int side) const;

  bool empty() const { return bricks_.empty(); }
  std::size_t size() const { return size_; }
  std::size_t bytes() const { return bytes_; }  ///< of the packed voxels and colours

 private:
  struct Packed {
    double travelled;
    std::int32_t state;
    std::vector<std::byte> bytes;
  };
  struct Codec;
  using Key = std::array<std::int32_t, 3>;  ///< z, y, x
  static Key order_of(const kernels::VoxelPosition& p) { return {p.z, p.y, p.x}; }

  const Packed& at(const kernels::VoxelPosition& position, double travelled) const;
  BrickWords unpack(const Packed& packed) const;

  bool with_color_;
  std::size_t bytes_ = 0, size_ = 0;
  std::map<Key, std::vector<Packed>> bricks_;  ///< of a position by ascending `travelled`
  std::unique_ptr<Codec> codec_;
};

}  // namespace plumbline
