// Formats that are little more than their numbers: PGM (16-bit depth), PPM (colour) and NumPy's NPY.
#pragma once

#include <string>
#include <string_view>

#include "io/images/png.h"
#include "plumbline/image.h"

namespace plumbline {

bool is_pgm(std::string_view bytes);
bool is_ppm(std::string_view bytes);
bool is_npy(std::string_view bytes);

/// These throw Error for a truncated or damaged file, and one with more than 16384 pixels a side; `name` is the file's
/// name for errors.
/// Also of a PPM.
ImageHeader read_pgm_header(std::string_view bytes, const std::string& name);
ImageHeader read_npy_header(std::string_view bytes, const std::string& name);
/// Grey of more than 8 bits, most significant byte first.
Image<float> decode_depth_pgm(std::string_view bytes, const std::string& name);
/// Height × width of uint16, float32 or float64, least significant byte first, in rows.
Image<float> decode_depth_npy(std::string_view bytes, const std::string& name);

/// 8 bits of red, green and blue.
ColorImage decode_color_ppm(std::string_view bytes, const std::string& name);

}  // namespace plumbline
