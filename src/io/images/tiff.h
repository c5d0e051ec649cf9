// TIFF through libtiff: depth of 16-bit integers or 32-bit real numbers.
#pragma once

#include <string>
#include <string_view>

#include "io/images/png.h"
#include "plumbline/image.h"

namespace plumbline {

bool is_tiff(std::string_view bytes);

/// These throw Error for a truncated or damaged file, and one with more than 16384 pixels a side; `name` is the file's
/// name for errors.
ImageHeader read_tiff_header(std::string_view bytes, const std::string& name);
/// One channel of 16-bit integers or 32-bit real numbers. Throws Error for other kinds.
Image<float> decode_depth_tiff(std::string_view bytes, const std::string& name);

}  // namespace plumbline
