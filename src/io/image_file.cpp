#include "io/image_file.h"

#include "io/jpeg.h"
#include "io/text_file.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

[[noreturn]] void fail_unknown(const std::string& bytes, const std::string& path) {
  if (bytes.empty()) throw Error("the image file is empty", path, "copy or download the file again");
  throw Error("is neither a PNG nor a JPEG", path, "give images in one of these formats");
}

}  // namespace

ImageHeader read_image_header(const std::string& path) {
  const std::string bytes = read_file(path);
  if (is_png(bytes)) return read_png_header(bytes, path);
  if (is_jpeg(bytes)) return read_jpeg_header(bytes, path);
  fail_unknown(bytes, path);
}

DepthImage read_depth_image(const std::string& path, double) {
  const std::string bytes = read_file(path);
  if (is_png(bytes)) return decode_depth_png(bytes, path);
  if (is_jpeg(bytes))
    throw Error("is a JPEG, where 16-bit grey depth is expected", path, "give depth as 16-bit greyscale PNG files");
  fail_unknown(bytes, path);
}

ColorImage read_color_image(const std::string& path) {
  const std::string bytes = read_file(path);
  if (is_png(bytes)) return decode_color_png(bytes, path);
  if (is_jpeg(bytes)) return decode_jpeg(bytes, path);
  fail_unknown(bytes, path);
}

}  // namespace plumbline
