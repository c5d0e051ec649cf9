#include "io/images/jpeg.h"

#include <turbojpeg.h>

#include <memory>
#include <new>

#include "io/images/image_size.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

struct HandleDeleter {
  void operator()(void* handle) const { tjDestroy(handle); }
};
using Handle = std::unique_ptr<void, HandleDeleter>;

Handle make_decompressor() {
  Handle handle(tjInitDecompress());
  if (!handle) throw std::bad_alloc();
  return handle;
}

[[noreturn]] void fail(const Handle& handle, const std::string& name) {
  throw Error(std::string("the JPEG is truncated or damaged (") + tjGetErrorStr2(handle.get()) + ")", name,
              "copy or download the file again");
}

const unsigned char* data_of(std::string_view bytes) { return reinterpret_cast<const unsigned char*>(bytes.data()); }

ImageHeader read_header(const Handle& handle, std::string_view bytes, const std::string& name) {
  ImageHeader header;
  int subsampling = 0, colorspace = 0;
  if (tjDecompressHeader3(handle.get(), data_of(bytes), bytes.size(), &header.width, &header.height, &subsampling,
                          &colorspace) != 0)
    fail(handle, name);
  if (header.width > kMaxImageSide || header.height > kMaxImageSide)
    throw Error("the JPEG has more than 16384 pixels a side", name, "give a smaller image");
  header.bit_depth = 8;
  header.description = "JPEG";
  return header;
}

}  // namespace

bool is_jpeg(std::string_view bytes) { return bytes.starts_with("\xFF\xD8\xFF"); }

ImageHeader read_jpeg_header(std::string_view bytes, const std::string& name) {
  return read_header(make_decompressor(), bytes, name);
}

ColorImage decode_jpeg(std::string_view bytes, const std::string& name) {
  const Handle handle = make_decompressor();
  const ImageHeader header = read_header(handle, bytes, name);
  ColorImage color(header.width, header.height, 3);
  // A truncated file is only a warning to the library, which would fill the rest with grey.
  if (tjDecompress2(handle.get(), data_of(bytes), bytes.size(), color.pixels.data(), header.width, 0, header.height,
                    TJPF_RGB, TJFLAG_STOPONWARNING) != 0)
    fail(handle, name);
  return color;
}

std::string encode_jpeg(const ColorImage& image, int quality) {
  const Handle handle(tjInitCompress());
  if (!handle) throw std::bad_alloc();
  unsigned long size = tjBufSize(image.width, image.height, TJSAMP_420);
  std::string bytes(size, '\0');
  auto* out = reinterpret_cast<unsigned char*>(bytes.data());
  if (tjCompress2(handle.get(), image.pixels.data(), image.width, 0, image.height, TJPF_RGB, &out, &size, TJSAMP_420,
                  quality, TJFLAG_NOREALLOC) != 0)
    throw std::bad_alloc();
  bytes.resize(size);
  return bytes;
}

}  // namespace plumbline
