// The image that explains a frame: why each pixel was or was not used.
#pragma once

#include <string>

#include "plumbline/image.h"

namespace plumbline::app {

/// Paints `PixelUse` codes: used green, no depth black, no normal grey, out of view blue, nothing predicted purple, too
/// far red, wrong angle orange, filtered yellow. Throws Error if the file cannot be written.
void write_pixel_use(const std::string& path, const Image<std::uint8_t>& codes);

}  // namespace plumbline::app
