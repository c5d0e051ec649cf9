// Gzipped bytes.
#pragma once

#include <string>
#include <string_view>

namespace plumbline {

bool is_gzip(std::string_view bytes);

/// All members of a gzip file, unpacked. Throws Error for damaged or cut-off bytes, and beyond 2 GiB; `name` is the
/// file's name for errors.
std::string gunzip(std::string_view bytes, const std::string& name);

}  // namespace plumbline
