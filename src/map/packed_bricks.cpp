#include "map/packed_bricks.h"

#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

namespace plumbline {
namespace {

constexpr std::size_t kWords = kernels::kBrickVoxels;
constexpr std::size_t kBytes = kWords * sizeof(std::int32_t);
// The fastest: what is packed was just seen, and may be wanted again soon.
constexpr int kLevel = 1;

/// The lowest byte of each word, then the second one of each …: weights and the upper halves of distances are alike
/// among neighbours, and compress once they lie together.
void split(const std::int32_t* words, std::byte* planes) {
  for (std::size_t i = 0; i < kWords; ++i) {
    const auto word = static_cast<std::uint32_t>(words[i]);
    for (std::size_t k = 0; k < sizeof(word); ++k) planes[k * kWords + i] = static_cast<std::byte>(word >> (8 * k));
  }
}

void join(const std::byte* planes, std::int32_t* words) {
  for (std::size_t i = 0; i < kWords; ++i) {
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < sizeof(word); ++k)
      word |= std::to_integer<std::uint32_t>(planes[k * kWords + i]) << (8 * k);
    words[i] = static_cast<std::int32_t>(word);
  }
}

}  // namespace

/// zstd's memory, kept between calls.
struct PackedBricks::Codec {
  Codec() : compressor(ZSTD_createCCtx()), decompressor(ZSTD_createDCtx()), packed(ZSTD_compressBound(2 * kBytes)) {
    if (compressor == nullptr || decompressor == nullptr) throw std::bad_alloc();
  }
  ~Codec() {
    ZSTD_freeCCtx(compressor);
    ZSTD_freeDCtx(decompressor);
  }
  Codec(const Codec&) = delete;
  Codec& operator=(const Codec&) = delete;

  ZSTD_CCtx* compressor;
  ZSTD_DCtx* decompressor;
  std::array<std::byte, 2 * kBytes> planes{};
  std::vector<std::byte> packed;
};

PackedBricks::PackedBricks(bool with_color) : with_color_(with_color), codec_(std::make_unique<Codec>()) {}
PackedBricks::~PackedBricks() = default;
PackedBricks::PackedBricks(PackedBricks&&) noexcept = default;
PackedBricks& PackedBricks::operator=(PackedBricks&&) noexcept = default;

void PackedBricks::keep(const kernels::VoxelPosition& position, double travelled, std::int32_t state,
                        const std::int32_t* voxels, const std::int32_t* colors) {
  Codec& codec = *codec_;
  split(voxels, codec.planes.data());
  if (with_color_) split(colors, codec.planes.data() + kBytes);
  const std::size_t size = ZSTD_compressCCtx(codec.compressor, codec.packed.data(), codec.packed.size(),
                                             codec.planes.data(), with_color_ ? 2 * kBytes : kBytes, kLevel);
  if (ZSTD_isError(size) != 0) throw std::bad_alloc();  // the buffer is large enough: nothing else is missing
  if (contains(position) && nearest(position, travelled) == travelled) remove(position, travelled);
  std::vector<Packed>& here = bricks_[order_of(position)];
  const auto later = std::upper_bound(here.begin(), here.end(), travelled,
                                      [](double value, const Packed& packed) { return value < packed.travelled; });
  const auto end = codec.packed.begin() + static_cast<std::ptrdiff_t>(size);
  here.insert(later, Packed{travelled, state, std::vector<std::byte>(codec.packed.begin(), end)});
  bytes_ += size;
  ++size_;
}

double PackedBricks::nearest(const kernels::VoxelPosition& position, double travelled) const {
  const std::vector<Packed>& here = bricks_.at(order_of(position));
  const auto nearer = [&](const Packed& a, const Packed& b) {
    return std::abs(a.travelled - travelled) < std::abs(b.travelled - travelled);
  };
  return std::min_element(here.begin(), here.end(), nearer)->travelled;
}

const PackedBricks::Packed& PackedBricks::at(const kernels::VoxelPosition& position, double travelled) const {
  const std::vector<Packed>& here = bricks_.at(order_of(position));
  return *std::find_if(here.begin(), here.end(), [&](const Packed& packed) { return packed.travelled == travelled; });
}

BrickWords PackedBricks::unpack(const kernels::VoxelPosition& position, double travelled) const {
  return unpack(at(position, travelled));
}

BrickWords PackedBricks::unpack_latest(const kernels::VoxelPosition& position) const {
  return unpack(bricks_.at(order_of(position)).back());
}

BrickWords PackedBricks::unpack(const Packed& packed) const {
  Codec& codec = *codec_;
  ZSTD_decompressDCtx(codec.decompressor, codec.planes.data(), codec.planes.size(), packed.bytes.data(),
                      packed.bytes.size());
  BrickWords brick;
  brick.state = packed.state;
  join(codec.planes.data(), brick.voxels.data());
  if (with_color_) join(codec.planes.data() + kBytes, brick.colors.data());
  return brick;
}

void PackedBricks::remove(const kernels::VoxelPosition& position, double travelled) {
  const auto found = bricks_.find(order_of(position));
  std::vector<Packed>& here = found->second;
  bytes_ -= at(position, travelled).bytes.size();
  --size_;
  std::erase_if(here, [&](const Packed& packed) { return packed.travelled == travelled; });
  if (here.empty()) bricks_.erase(found);
}

std::vector<kernels::VoxelPosition> PackedBricks::positions() const {
  std::vector<kernels::VoxelPosition> result;
  result.reserve(bricks_.size());
  for (const auto& [key, packed] : bricks_) result.push_back({key[2], key[1], key[0]});
  return result;
}

std::vector<kernels::VoxelPosition> PackedBricks::positions_in(const kernels::VoxelPosition& lowest, int side) const {
  constexpr std::int32_t kLowest = std::numeric_limits<std::int32_t>::min();
  std::vector<kernels::VoxelPosition> result;
  const auto end = bricks_.lower_bound({lowest.z + side, kLowest, kLowest});
  for (auto brick = bricks_.lower_bound({lowest.z, kLowest, kLowest}); brick != end; ++brick) {
    const auto [z, y, x] = brick->first;
    if (y >= lowest.y && y < lowest.y + side && x >= lowest.x && x < lowest.x + side) result.push_back({x, y, z});
  }
  return result;
}

}  // namespace plumbline
