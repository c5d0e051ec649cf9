// Image files of any format that is read, told apart by their first bytes and not by their names.
#pragma once

#include <string>

#include "io/images/png.h"
#include "plumbline/image.h"

namespace plumbline {

/// Width, height and kind. Throws Error if the file is neither PNG nor JPEG.
ImageHeader read_image_header(const std::string& path);

/// Readings per metre of depth that files hold as real numbers of metres: 0.2 mm, up to 13.1 m.
constexpr double kReadingsOfFloat = 5000;

/// 16-bit grey, or real numbers, which become readings of `float_unit` each (0 if not finite, not positive or beyond
/// 65535). Throws Error naming the file if it is anything else, is damaged or ends early.
DepthImage read_depth_image(const std::string& path, double float_unit = kReadingsOfFloat);

/// PNG or JPEG as 8-bit RGB. Throws Error as above.
ColorImage read_color_image(const std::string& path);

}  // namespace plumbline
