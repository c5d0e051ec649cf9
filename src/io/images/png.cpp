#include "io/images/png.h"

#include <spng.h>

#include <bit>
#include <cstdlib>
#include <memory>

#include "io/images/image_size.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

// DEFLATE spends at least one bit on 258 bytes, so each byte says at most 8 · 258 (RFC 1951).
constexpr std::size_t kMaxDeflateRatio = 2064;

/// How hard to compress. Measured on TUM frames: a filter makes depth larger and three times as slow to write, while
/// colour needs one; more than this costs several times the time for a tenth of the size.
struct Compression {
  int level;
  int filters;
};
constexpr Compression kDepthCompression = {2, SPNG_FILTER_CHOICE_NONE};
constexpr Compression kColorCompression = {1, SPNG_FILTER_CHOICE_SUB};

struct ContextDeleter {
  void operator()(spng_ctx* context) const { spng_ctx_free(context); }
};
using Context = std::unique_ptr<spng_ctx, ContextDeleter>;

Context make_context(int flags) {
  Context context(spng_ctx_new(flags));
  if (!context) throw std::bad_alloc();
  return context;
}

void check(int code, const std::string& name) {
  if (code == SPNG_EMEM) throw std::bad_alloc();
  if (code != SPNG_OK)
    throw Error(std::string("the PNG is truncated or damaged (") + spng_strerror(code) + ")", name,
                "copy or download the file again");
}

/// A decoder standing before the pixels.
class Decoder {
 public:
  Decoder(std::string_view bytes, const std::string& name) : name_(name), context_(make_context(0)) {
    if (!is_png(bytes)) throw Error("is not a PNG", name, "give a PNG file");
    check(spng_set_image_limits(context_.get(), kMaxImageSide, kMaxImageSide), name);
    check(spng_set_png_buffer(context_.get(), bytes.data(), bytes.size()), name);
    check(spng_get_ihdr(context_.get(), &header), name);
    const std::size_t pixels = static_cast<std::size_t>(header.width) * header.height;
    if (pixels / 8 > bytes.size() * kMaxDeflateRatio)
      throw Error("the PNG is truncated: it is too small for its " + std::to_string(header.width) + "x" +
                      std::to_string(header.height) + " pixels",
                  name, "copy or download the file again");
  }

  void decode(void* pixels, std::size_t bytes, int format) {
    std::size_t needed = 0;
    check(spng_decoded_image_size(context_.get(), format, &needed), name_);
    if (needed != bytes) throw Error("the PNG's pixels have an unexpected size", name_, "report this file");
    check(spng_decode_image(context_.get(), pixels, bytes, format, 0), name_);
  }

  bool is_depth() const { return header.bit_depth == 16 && header.color_type == SPNG_COLOR_TYPE_GRAYSCALE; }
  int width() const { return static_cast<int>(header.width); }
  int height() const { return static_cast<int>(header.height); }

  spng_ihdr header{};

 private:
  std::string name_;
  Context context_;
};

std::string describe(const spng_ihdr& header) {
  const char* kind = "";
  switch (header.color_type) {
    case SPNG_COLOR_TYPE_GRAYSCALE:
      kind = "grey";
      break;
    case SPNG_COLOR_TYPE_TRUECOLOR:
      kind = "RGB";
      break;
    case SPNG_COLOR_TYPE_INDEXED:
      kind = "palette";
      break;
    case SPNG_COLOR_TYPE_GRAYSCALE_ALPHA:
      kind = "grey and alpha";
      break;
    default:
      kind = "RGBA";
      break;
  }
  return std::to_string(header.bit_depth) + "-bit " + kind + " PNG";
}

/// Throws if the images would not fill the planned number of bytes.
template <class T>
void check_writable(const Image<T>& image, const std::string& path) {
  const std::size_t expected = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) *
                               static_cast<std::size_t>(image.channels);
  if (image.width <= 0 || image.height <= 0 || image.pixels.size() != expected)
    throw Error("an image without pixels cannot be written", path, "give an image of at least one pixel");
}

template <class T>
void encode(const std::string& path, spng_ihdr header, const Image<T>& image, Compression compression,
            Durable durable) {
  const Context context = make_context(SPNG_CTX_ENCODER);
  check(spng_set_option(context.get(), SPNG_ENCODE_TO_BUFFER, 1), path);
  check(spng_set_option(context.get(), SPNG_IMG_COMPRESSION_LEVEL, compression.level), path);
  check(spng_set_option(context.get(), SPNG_FILTER_CHOICE, compression.filters), path);
  check(spng_set_ihdr(context.get(), &header), path);
  check(spng_encode_image(context.get(), image.pixels.data(), image.pixels.size() * sizeof(T), SPNG_FMT_PNG,
                          SPNG_ENCODE_FINALIZE),
        path);
  std::size_t size = 0;
  int error = 0;
  const std::unique_ptr<void, decltype(&std::free)> png(spng_get_png_buffer(context.get(), &size, &error), &std::free);
  check(error, path);
  AtomicFile file(path, durable);
  file.write(png.get(), size);
  file.commit();
}

spng_ihdr header_of(int width, int height, int bit_depth, int color_type) {
  spng_ihdr header{};
  header.width = static_cast<std::uint32_t>(width);
  header.height = static_cast<std::uint32_t>(height);
  header.bit_depth = static_cast<std::uint8_t>(bit_depth);
  header.color_type = static_cast<std::uint8_t>(color_type);
  return header;
}

}  // namespace

bool is_png(std::string_view bytes) { return bytes.starts_with("\x89PNG\r\n\x1A\n"); }

ImageHeader read_png_header(std::string_view bytes, const std::string& name) {
  const Decoder decoder(bytes, name);
  return {decoder.width(), decoder.height(), decoder.header.bit_depth, describe(decoder.header), decoder.is_depth()};
}

DepthImage decode_depth_png(std::string_view bytes, const std::string& name) {
  Decoder decoder(bytes, name);
  if (!decoder.is_depth())
    throw Error("16-bit grey depth is expected, but the file is: " + describe(decoder.header), name,
                "give the depth image itself, not a colour image or a picture made from depth");
  DepthImage depth(decoder.width(), decoder.height());
  decoder.decode(depth.pixels.data(), depth.pixels.size() * sizeof(depth.pixels[0]), SPNG_FMT_RAW);
  // The bytes of the file are big-endian. Turning them here vectorises, the decoder's own loop does not.
  if constexpr (std::endian::native == std::endian::little)
    for (std::uint16_t& v : depth.pixels) v = static_cast<std::uint16_t>((v >> 8) | (v << 8));
  return depth;
}

ColorImage decode_color_png(std::string_view bytes, const std::string& name) {
  Decoder decoder(bytes, name);
  ColorImage color(decoder.width(), decoder.height(), 3);
  decoder.decode(color.pixels.data(), color.pixels.size(), SPNG_FMT_RGB8);
  return color;
}

void write_depth_png(const std::string& path, const DepthImage& depth, Durable durable) {
  check_writable(depth, path);
  if (depth.channels != 1) throw Error("a depth image has one channel", path, "give one channel");
  encode(path, header_of(depth.width, depth.height, 16, SPNG_COLOR_TYPE_GRAYSCALE), depth, kDepthCompression, durable);
}

namespace {

int color_type(int channels, const std::string& path) {
  switch (channels) {
    case 1:
      return SPNG_COLOR_TYPE_GRAYSCALE;
    case 3:
      return SPNG_COLOR_TYPE_TRUECOLOR;
    case 4:
      return SPNG_COLOR_TYPE_TRUECOLOR_ALPHA;
    default:
      throw Error("a picture of " + std::to_string(channels) + " channels cannot be written", path,
                  "give 1 (grey), 3 (RGB) or 4 (RGBA) channels");
  }
}

}  // namespace

void write_color_png(const std::string& path, const ColorImage& image, Durable durable) {
  check_writable(image, path);
  const int type = color_type(image.channels, path);
  encode(path, header_of(image.width, image.height, 8, type), image, kColorCompression, durable);
}

}  // namespace plumbline
