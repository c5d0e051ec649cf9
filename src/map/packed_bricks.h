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

/// Positions are counted in bricks, in the frame of the map. Nothing is lost by packing.
class PackedBricks {
 public:
  explicit PackedBricks(bool with_color);
  ~PackedBricks();
  PackedBricks(PackedBricks&&) noexcept;
  PackedBricks& operator=(PackedBricks&&) noexcept;

  /// `colors` may be null without colour. A brick that is there already is replaced. Throws std::bad_alloc.
  void keep(const kernels::VoxelPosition& position, std::int32_t state, const std::int32_t* voxels,
            const std::int32_t* colors);
  /// The brick must be there.
  BrickWords unpack(const kernels::VoxelPosition& position) const;
  bool contains(const kernels::VoxelPosition& position) const { return bricks_.contains(order_of(position)); }
  void remove(const kernels::VoxelPosition& position);

  /// Of all bricks, ordered by z, y, x.
  std::vector<kernels::VoxelPosition> positions() const;
  /// Of those in a cube with this lowest corner, in the same order.
  std::vector<kernels::VoxelPosition> positions_in(const kernels::VoxelPosition& lowest, int side) const;

  bool empty() const { return bricks_.empty(); }
  std::size_t size() const { return bricks_.size(); }
  std::size_t bytes() const { return bytes_; }  ///< of the packed voxels and colours

 private:
  struct Packed {
    std::int32_t state;
    std::vector<std::byte> bytes;
  };
  struct Codec;
  using Key = std::array<std::int32_t, 3>;  ///< z, y, x
  static Key order_of(const kernels::VoxelPosition& p) { return {p.z, p.y, p.x}; }

  bool with_color_;
  std::size_t bytes_ = 0;
  std::map<Key, Packed> bricks_;
  std::unique_ptr<Codec> codec_;
};

}  // namespace plumbline
