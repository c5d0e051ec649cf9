// OpenEXR through its own library: depth as real numbers.
#pragma once

#include <string>
#include <string_view>

#include "io/images/png.h"
#include "plumbline/image.h"

namespace plumbline {

bool is_exr(std::string_view bytes);

/// These throw Error for a truncated or damaged file, one with more than 16384 pixels a side, and where the library is
/// missing; `name` is the file's name for errors.
ImageHeader read_exr_header(std::string_view bytes, const std::string& name);
/// The channel Z, D, depth, Y or R, the first of these that there is, else the first of all.
Image<float> decode_depth_exr(std::string_view bytes, const std::string& name);

}  // namespace plumbline
