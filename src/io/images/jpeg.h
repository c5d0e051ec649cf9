// JPEG through libjpeg-turbo.
#pragma once

#include <string>
#include <string_view>

#include "io/images/png.h"
#include "plumbline/image.h"

namespace plumbline {

bool is_jpeg(std::string_view bytes);

/// Both throw Error for a truncated or damaged file; `name` is the file's name for errors.
ImageHeader read_jpeg_header(std::string_view bytes, const std::string& name);
/// 8-bit RGB; grey is repeated.
ColorImage decode_jpeg(std::string_view bytes, const std::string& name);

/// Of an RGB image; `quality` 1 … 100. Throws std::bad_alloc.
std::string encode_jpeg(const ColorImage& image, int quality);

}  // namespace plumbline
