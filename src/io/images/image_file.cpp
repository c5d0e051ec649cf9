#include "io/images/image_file.h"

#include "io/images/exr.h"
#include "io/images/jpeg.h"
#include "io/images/plain_depth.h"
#include "io/images/tiff.h"
#include "io/text_file.h"
#include "plumbline/error.h"
#include "plumbline/frame.h"

namespace plumbline {
namespace {

[[noreturn]] void fail_unknown(const std::string& bytes, const std::string& path) {
  if (bytes.empty()) throw Error("the image file is empty", path, "copy or download the file again");
  throw Error("is neither a PNG nor a JPEG, and no TIFF, PGM, EXR or NPY of depth", path,
              "give images in one of these formats");
}

}  // namespace

ImageHeader read_image_header(const std::string& path) {
  constexpr std::size_t kBeginning = 64 << 10;
  std::string bytes = read_beginning(path, kBeginning);
  // A TIFF's directory, an EXR's table and a JPEG's size may stand further back.
  if (is_tiff(bytes) || is_exr(bytes) || is_jpeg(bytes)) bytes = read_file(path);
  if (is_png(bytes)) return read_png_header(bytes, path);
  if (is_jpeg(bytes)) return read_jpeg_header(bytes, path);
  if (is_tiff(bytes)) return read_tiff_header(bytes, path);
  if (is_exr(bytes)) return read_exr_header(bytes, path);
  if (is_pgm(bytes) || is_ppm(bytes)) return read_pgm_header(bytes, path);
  if (is_npy(bytes)) return read_npy_header(bytes, path);
  fail_unknown(bytes, path);
}

DepthImage read_depth_image(const std::string& path, double float_unit) {
  const std::string bytes = read_file(path);
  if (is_png(bytes)) return decode_depth_png(bytes, path);
  if (is_tiff(bytes))
    return readings_of(decode_depth_tiff(bytes, path), read_tiff_header(bytes, path).is_float ? float_unit : 1);
  if (is_exr(bytes)) return readings_of(decode_depth_exr(bytes, path), float_unit);
  if (is_pgm(bytes)) return readings_of(decode_depth_pgm(bytes, path), 1);
  if (is_npy(bytes))
    return readings_of(decode_depth_npy(bytes, path), read_npy_header(bytes, path).is_float ? float_unit : 1);
  if (is_jpeg(bytes))
    throw Error("is a JPEG, where 16-bit grey depth is expected", path, "give depth as 16-bit greyscale PNG files");
  fail_unknown(bytes, path);
}

ColorImage read_color_image(const std::string& path) {
  const std::string bytes = read_file(path);
  if (is_png(bytes)) return decode_color_png(bytes, path);
  if (is_jpeg(bytes)) return decode_jpeg(bytes, path);
  if (is_ppm(bytes)) return decode_color_ppm(bytes, path);
  if (bytes.empty()) fail_unknown(bytes, path);
  throw Error("is neither a PNG nor a JPEG nor a PPM", path, "give colour in one of these formats");
}

}  // namespace plumbline
