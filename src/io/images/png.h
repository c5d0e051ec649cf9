// PNG through libspng.
#pragma once

#include <string>
#include <string_view>

#include "io/atomic_file.h"
#include "plumbline/image.h"

namespace plumbline {

/// Size and kind of an image file, from its first bytes.
struct ImageHeader {
  int width = 0, height = 0;
  int bit_depth = 0;        ///< bits a channel
  std::string description;  ///< "16-bit grey PNG", "8-bit RGB PNG", "JPEG" …
  bool is_depth = false;    ///< 16-bit grey with nothing beside it, or real numbers
  bool is_float = false;    ///< real numbers
};

bool is_png(std::string_view bytes);

/// The decoders take a file's bytes; `name` is the file's name for errors. They throw Error for a truncated or damaged
/// file, one of the wrong kind, and one with more than 16384 pixels a side.
ImageHeader read_png_header(std::string_view bytes, const std::string& name);

/// 16-bit grey only. Readings in the host's byte order.
DepthImage decode_depth_png(std::string_view bytes, const std::string& name);

/// Any kind of PNG as 8-bit RGB: grey is repeated, palettes are looked up, alpha falls away, 16 bits keep the upper 8.
ColorImage decode_color_png(std::string_view bytes, const std::string& name);

/// 16-bit grey. Throws Error if the image is empty or the file cannot be written.
void write_depth_png(const std::string& path, const DepthImage& depth, Durable durable = Durable::no);

/// 8-bit grey (1 channel), RGB (3) or RGBA (4). Throws Error as above and for other numbers of channels.
void write_color_png(const std::string& path, const ColorImage& image, Durable durable = Durable::no);

}  // namespace plumbline
