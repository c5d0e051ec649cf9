// RVL: lossless depth compression (Wilson, "Fast Lossless Depth Image Compression", ISS 2017).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace plumbline {

/// `count` readings. Throws Error if the bytes end before or hold more than `count`; `name` is the file's name for
/// errors.
std::vector<std::uint16_t> decode_rvl(std::string_view bytes, std::size_t count, const std::string& name);

}  // namespace plumbline
