#include "io/gzip.h"

#include <zlib.h>

#include <algorithm>
#include <limits>

#include "plumbline/error.h"

namespace plumbline {
namespace {

constexpr std::size_t kMaxSize = std::size_t{1} << 31;
constexpr int kGzipOnly = 16;  // see inflateInit2 in zlib.h

struct Inflater {
  z_stream stream{};
  Inflater() { ready = inflateInit2(&stream, MAX_WBITS + kGzipOnly) == Z_OK; }
  ~Inflater() {
    if (ready) inflateEnd(&stream);
  }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
  bool ready = false;
};

[[noreturn]] void fail(const std::string& what, const std::string& name) {
  throw Error(what, name, "copy or unpack the file again");
}

}  // namespace

bool is_gzip(std::string_view bytes) { return bytes.starts_with("\x1f\x8b"); }

std::string gunzip(std::string_view bytes, const std::string& name) {
  Inflater inflater;
  z_stream& stream = inflater.stream;
  if (!inflater.ready) fail("cannot be unpacked", name);
  if (bytes.size() > std::numeric_limits<uInt>::max()) fail("is too large to be unpacked", name);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));  // zlib does not write to it
  stream.avail_in = static_cast<uInt>(bytes.size());
  std::string text;
  std::size_t size = 0;
  for (;;) {
    if (size == text.size()) text.resize(std::max<std::size_t>(1 << 16, 2 * size));
    const std::size_t room = std::min<std::size_t>(text.size() - size, 1 << 30);
    stream.next_out = reinterpret_cast<Bytef*>(text.data() + size);
    stream.avail_out = static_cast<uInt>(room);
    const int status = inflate(&stream, Z_NO_FLUSH);
    const std::size_t produced = room - stream.avail_out;
    size += produced;
    if (size > kMaxSize) fail("holds more than 2 GiB of text", name);
    if (status == Z_STREAM_END) {
      if (stream.avail_in == 0) break;
      if (inflateReset(&stream) != Z_OK) fail("cannot be unpacked", name);  // the next member
    } else if (status != Z_OK || (produced == 0 && stream.avail_in == 0)) {
      fail(stream.avail_in == 0 ? "ends early" : "is damaged: it cannot be unpacked", name);
    }
  }
  text.resize(size);
  return text;
}

}  // namespace plumbline
