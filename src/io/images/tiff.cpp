#include "io/images/tiff.h"

#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include "io/images/image_size.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

constexpr const char* kTiffAdvice = "give depth as one channel of 16-bit integers or 32-bit real numbers";

struct TiffCursor {
  std::string_view bytes;
  std::uint64_t at = 0;
};

tmsize_t read_bytes(thandle_t handle, void* out, tmsize_t size) {
  auto* cursor = static_cast<TiffCursor*>(handle);
  if (cursor->at >= cursor->bytes.size() || size <= 0) return 0;
  const auto n = std::min<std::uint64_t>(static_cast<std::uint64_t>(size), cursor->bytes.size() - cursor->at);
  std::memcpy(out, cursor->bytes.data() + cursor->at, n);
  cursor->at += n;
  return static_cast<tmsize_t>(n);
}

tmsize_t write_nothing(thandle_t, void*, tmsize_t) { return 0; }

toff_t seek(thandle_t handle, toff_t offset, int whence) {
  auto* cursor = static_cast<TiffCursor*>(handle);
  cursor->at = offset + (whence == SEEK_CUR ? cursor->at : whence == SEEK_END ? cursor->bytes.size() : 0);
  return cursor->at;
}

int close_nothing(thandle_t) { return 0; }
toff_t size_of(thandle_t handle) { return static_cast<TiffCursor*>(handle)->bytes.size(); }

/// 1: the message is dealt with.
int say_nothing(TIFF*, void*, const char*, const char*, va_list) { return 1; }

struct TiffCloser {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};

/// An open file in memory. libtiff's own messages go nowhere.
struct Reader {
  Reader(std::string_view bytes, const std::string& file_name) : cursor{bytes}, name(file_name) {
    // Handlers of this file alone: those that libtiff keeps for the whole process are the caller's.
    const std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(TIFFOpenOptionsAlloc(),
                                                                                   TIFFOpenOptionsFree);
    TIFFOpenOptionsSetErrorHandlerExtR(options.get(), say_nothing, nullptr);
    TIFFOpenOptionsSetWarningHandlerExtR(options.get(), say_nothing, nullptr);
    tiff.reset(TIFFClientOpenExt("tiff", "rm", &cursor, read_bytes, write_nothing, seek, close_nothing, size_of,
                                 nullptr, nullptr, options.get()));
    if (!tiff) fail("is a damaged TIFF");
    TIFFGetField(tiff.get(), TIFFTAG_IMAGEWIDTH, &width);
    TIFFGetField(tiff.get(), TIFFTAG_IMAGELENGTH, &height);
    TIFFGetFieldDefaulted(tiff.get(), TIFFTAG_BITSPERSAMPLE, &bits);
    TIFFGetFieldDefaulted(tiff.get(), TIFFTAG_SAMPLESPERPIXEL, &channels);
    TIFFGetFieldDefaulted(tiff.get(), TIFFTAG_SAMPLEFORMAT, &kind);
    if (width == 0 || height == 0 || width > kMaxImageSide || height > kMaxImageSide)
      fail(fmt::format("is a TIFF of {}x{} pixels", width, height));
  }

  [[noreturn]] void fail(const std::string& what) const { throw Error(what, name, "copy or export the file again"); }

  bool is_float() const { return channels == 1 && bits == 32 && kind == SAMPLEFORMAT_IEEEFP; }
  bool is_depth() const { return is_float() || (channels == 1 && bits == 16 && kind == SAMPLEFORMAT_UINT); }
  std::string describe() const {
    return fmt::format("{}-bit {} TIFF of {} channel{}", bits, kind == SAMPLEFORMAT_IEEEFP ? "real" : "integer",
                       channels, channels == 1 ? "" : "s");
  }

  TiffCursor cursor;
  const std::string& name;
  std::unique_ptr<TIFF, TiffCloser> tiff;
  std::uint32_t width = 0, height = 0;
  std::uint16_t bits = 0, channels = 0, kind = 0;
};

}  // namespace

bool is_tiff(std::string_view bytes) {
  return bytes.starts_with(std::string_view("II*\0", 4)) || bytes.starts_with(std::string_view("MM\0*", 4));
}

ImageHeader read_tiff_header(std::string_view bytes, const std::string& name) {
  const Reader reader(bytes, name);
  return {static_cast<int>(reader.width),
          static_cast<int>(reader.height),
          reader.bits,
          reader.describe(),
          reader.is_depth(),
          reader.is_float()};
}

Image<float> decode_depth_tiff(std::string_view bytes, const std::string& name) {
  const Reader reader(bytes, name);
  if (!reader.is_depth()) throw Error("depth is expected, but the file is: " + reader.describe(), name, kTiffAdvice);
  if (TIFFIsTiled(reader.tiff.get()) != 0) throw Error("is a TIFF in tiles, which is not read", name, kTiffAdvice);
  const tmsize_t row_bytes = TIFFScanlineSize(reader.tiff.get());
  if (row_bytes != static_cast<tmsize_t>(reader.width) * reader.bits / 8) reader.fail("is a damaged TIFF");
  Image<float> depth(static_cast<int>(reader.width), static_cast<int>(reader.height));
  std::vector<std::uint16_t> integers(reader.is_float() ? 0 : reader.width);
  for (std::uint32_t y = 0; y < reader.height; ++y) {
    float* row = depth.row(static_cast<int>(y));
    void* into = reader.is_float() ? static_cast<void*>(row) : integers.data();
    if (TIFFReadScanline(reader.tiff.get(), into, y) < 0) reader.fail("is a truncated or damaged TIFF");
    if (!reader.is_float()) std::copy(integers.begin(), integers.end(), row);
  }
  return depth;
}

}  // namespace plumbline
