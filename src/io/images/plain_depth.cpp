#include "io/images/plain_depth.h"

#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <optional>

#include "io/images/image_size.h"
#include "io/text_file.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

static_assert(std::endian::native == std::endian::little);

[[noreturn]] void fail_plain_depth(const std::string& what, const std::string& name) {
  throw Error(what, name, "copy or export the file again, or give depth as 16-bit PNG files");
}

struct Layout {
  int width = 0, height = 0, bytes = 0;
  bool is_float = false;
  std::string_view data;
};

void check(const Layout& layout, const std::string& name) {
  const auto needed = static_cast<std::size_t>(layout.width) * layout.height * layout.bytes;
  if (layout.data.size() < needed) fail_plain_depth("the image file ends early", name);
}

/// The next word of a PGM's head, past comments.
std::string_view next_word(std::string_view* rest) {
  while (!rest->empty() && (std::isspace(static_cast<unsigned char>(rest->front())) != 0 || rest->front() == '#')) {
    const std::size_t end = rest->front() == '#' ? std::min(rest->find('\n'), rest->size() - 1) : 0;
    rest->remove_prefix(end + 1);
  }
  std::size_t n = 0;
  while (n < rest->size() && std::isspace(static_cast<unsigned char>((*rest)[n])) == 0) ++n;
  const std::string_view word = rest->substr(0, n);
  rest->remove_prefix(n);
  return word;
}

int side(std::optional<long long> value, const std::string& name) {
  if (!value || *value < 1 || *value > kMaxImageSide) fail_plain_depth("has no size that an image can have", name);
  return static_cast<int>(*value);
}

Layout pgm_layout(std::string_view bytes, const std::string& name) {
  std::string_view rest = bytes.substr(2);
  Layout layout;
  layout.width = side(parse_unsigned(next_word(&rest)), name);
  layout.height = side(parse_unsigned(next_word(&rest)), name);
  const auto max = parse_unsigned(next_word(&rest));
  if (!max || *max < 1 || *max > 65535 || rest.empty()) fail_plain_depth("is a damaged PGM", name);
  layout.bytes = *max > 255 ? 2 : 1;
  layout.data = rest.substr(1);
  return layout;
}

/// The text after `key` in NPY's head, a Python dictionary.
std::string_view value_of(std::string_view head, std::string_view key, const std::string& name) {
  const std::size_t at = head.find(key);
  if (at == std::string_view::npos) fail_plain_depth("is a damaged NPY file", name);
  return trim(head.substr(at + key.size()));
}

Layout npy_layout(std::string_view bytes, const std::string& name) {
  if (bytes.size() < 12) fail_plain_depth("is a damaged NPY file", name);
  const bool first = bytes[6] == 1;
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 8, first ? 2 : 4);
  const std::size_t start = first ? 10 : 12;
  if (length > bytes.size() - start) fail_plain_depth("is a damaged NPY file", name);
  const std::string_view head = bytes.substr(start, length);
  Layout layout;
  layout.data = bytes.substr(start + length);
  const std::string_view kind = value_of(head, "'descr':", name);
  if (kind.starts_with("'<u2'")) layout.bytes = 2;
  if (kind.starts_with("'<f4'")) layout.bytes = 4, layout.is_float = true;
  if (kind.starts_with("'<f8'")) layout.bytes = 8, layout.is_float = true;
  if (layout.bytes == 0)
    fail_plain_depth(fmt::format("is an NPY file of {}, not of uint16 or float32", kind.substr(0, 6)), name);
  if (!value_of(head, "'fortran_order':", name).starts_with("False"))
    fail_plain_depth("is an NPY file in columns", name);
  std::string_view shape = value_of(head, "'shape':", name);
  const std::size_t end = shape.find(')');
  if (!shape.starts_with("(") || end == std::string_view::npos) fail_plain_depth("is a damaged NPY file", name);
  const auto sides = split_fields(shape.substr(1, end - 1), true);
  if (sides.size() != 2 && !(sides.size() == 3 && sides[2] == "1"))
    fail_plain_depth("is an NPY file of no image's shape", name);
  layout.height = side(parse_unsigned(sides[0]), name);
  layout.width = side(parse_unsigned(sides[1]), name);
  return layout;
}

template <class T>
void copy_numbers(const Layout& layout, Image<float>* depth) {
  for (std::size_t i = 0; i < depth->pixels.size(); ++i) {
    T value{};
    std::memcpy(&value, layout.data.data() + i * sizeof(T), sizeof(T));
    depth->pixels[i] = static_cast<float>(value);
  }
}

}  // namespace

bool is_ppm(std::string_view bytes) { return bytes.starts_with("P6") && bytes.size() > 2; }
bool is_pgm(std::string_view bytes) { return bytes.starts_with("P5") && bytes.size() > 2; }
bool is_npy(std::string_view bytes) { return bytes.starts_with("\x93NUMPY"); }

ImageHeader read_pgm_header(std::string_view bytes, const std::string& name) {
  const Layout layout = pgm_layout(bytes, name);
  const bool grey = is_pgm(bytes);
  return {layout.width,
          layout.height,
          8 * layout.bytes,
          fmt::format("{}-bit {}", 8 * layout.bytes, grey ? "grey PGM" : "RGB PPM"),
          grey && layout.bytes == 2,
          false};
}

ImageHeader read_npy_header(std::string_view bytes, const std::string& name) {
  const Layout layout = npy_layout(bytes, name);
  return {layout.width,
          layout.height,
          8 * layout.bytes,
          layout.is_float ? "NPY of real numbers" : "NPY of 16-bit integers",
          true,
          layout.is_float};
}

Image<float> decode_depth_pgm(std::string_view bytes, const std::string& name) {
  const Layout layout = pgm_layout(bytes, name);
  if (layout.bytes != 2) fail_plain_depth("16-bit grey depth is expected, but the file is an 8-bit PGM", name);
  check(layout, name);
  Image<float> depth(layout.width, layout.height);
  for (std::size_t i = 0; i < depth.pixels.size(); ++i)
    depth.pixels[i] = static_cast<float>(static_cast<std::uint8_t>(layout.data[2 * i]) * 256 +
                                         static_cast<std::uint8_t>(layout.data[2 * i + 1]));
  return depth;
}

ColorImage decode_color_ppm(std::string_view bytes, const std::string& name) {
  Layout layout = pgm_layout(bytes, name);
  if (layout.bytes != 1) fail_plain_depth("8 bits a channel are expected, but the file is a 16-bit PPM", name);
  layout.bytes = 3;  // a pixel
  check(layout, name);
  ColorImage color(layout.width, layout.height, 3);
  std::memcpy(color.pixels.data(), layout.data.data(), color.pixels.size());
  return color;
}

Image<float> decode_depth_npy(std::string_view bytes, const std::string& name) {
  const Layout layout = npy_layout(bytes, name);
  check(layout, name);
  Image<float> depth(layout.width, layout.height);
  if (layout.bytes == 2) copy_numbers<std::uint16_t>(layout, &depth);
  if (layout.bytes == 4) copy_numbers<float>(layout, &depth);
  if (layout.bytes == 8) copy_numbers<double>(layout, &depth);
  return depth;
}

}  // namespace plumbline
