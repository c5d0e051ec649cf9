// Chunks of recordings, packed with bz2, LZ4 frames or Zstandard.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace plumbline {

enum class Packing { none, bz2, lz4, zstd };

/// "" and "none" are none; empty for names that are not known.
std::optional<Packing> packing_named(std::string_view name);

/// The bytes before they were packed; empty if `stored` is damaged or does not hold `size` bytes.
std::optional<std::string> unpack(Packing packing, std::string_view stored, std::size_t size);

/// Whether the bytes begin as a frame of Zstandard does.
bool is_zstd(std::string_view bytes);

/// A frame of Zstandard that says its size, or one that `limit` holds; empty if it is damaged or larger.
std::optional<std::string> unpack_zstd_frame(std::string_view stored, std::size_t limit);

}  // namespace plumbline
