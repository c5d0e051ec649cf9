#include "io/text_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <new>
#include <utility>

#include "core/error.h"

namespace plumbline {
namespace {

/// Closes a file descriptor when it leaves the scope.
struct Descriptor {
  int fd;
  explicit Descriptor(int descriptor) : fd(descriptor) {}
  ~Descriptor() {
    if (fd >= 0) close(fd);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
};

[[noreturn]] void fail_to_read(const std::string& path) {
  const int error = errno;
  throw Error(std::string("cannot be read: ") + std::strerror(error), path,
              error == ENOENT ? "check the path" : "check that the file is a regular file that you may read");
}

void read_all(int fd, const std::string& path, std::string* bytes) {
  std::size_t size = 0;
  for (;;) {
    if (size == bytes->size()) bytes->resize(size + 65536);
    const ssize_t n = read(fd, bytes->data() + size, bytes->size() - size);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail_to_read(path);
    if (n == 0) break;
    size += static_cast<std::size_t>(n);
  }
  bytes->resize(size);
}

/// The content of a gzip file, one member or several.
std::string inflated(const std::string& bytes, const std::string& path) {
  constexpr std::size_t kLargest = std::size_t{1} << 32;  // a small file must not fill the memory
  z_stream stream{};
  if (inflateInit2(&stream, 16 + MAX_WBITS) != Z_OK) throw std::bad_alloc();
  const std::unique_ptr<z_stream, int (*)(z_stream*)> guard(&stream, inflateEnd);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  std::string out;
  for (int state = Z_OK; state != Z_STREAM_END || stream.avail_in > 0;) {
    if (state == Z_STREAM_END) inflateReset(&stream);
    const std::size_t size = out.size();
    if (size >= kLargest) throw Error("unpacks to more than 4 GiB", path, "unpack it and give a part");
    out.resize(size + (std::size_t{1} << 18));
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + size);
    stream.avail_out = static_cast<uInt>(out.size() - size);
    state = inflate(&stream, Z_NO_FLUSH);
    out.resize(out.size() - stream.avail_out);
    if (state != Z_OK && state != Z_STREAM_END)
      throw Error("is a damaged gzip file", path, "fetch it again, or unpack it");
  }
  return out;
}

bool is_gzip(const std::string& bytes) { return bytes.starts_with("\x1f\x8b"); }

}  // namespace

std::string read_file(const std::string& path) {
  const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat status {};
  if (file.fd < 0 || fstat(file.fd, &status) != 0) fail_to_read(path);
  if (S_ISDIR(status.st_mode)) throw Error("is a folder, where a file is expected", path, "give the file in it");
  // One byte more than the size, so that the end is seen without growing the buffer.
  std::string bytes(static_cast<std::size_t>(status.st_size) + 1, '\0');
  read_all(file.fd, path, &bytes);
  return bytes;
}

TextFile::TextFile(const std::string& path) : path_(path) {
  std::string bytes = read_file(path);
  if (is_gzip(bytes)) bytes = inflated(bytes, path);
  content_ = std::make_shared<const std::string>(std::move(bytes));
  std::string_view rest = *content_;
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
  for (int number = 1; !rest.empty(); ++number) {
    const std::size_t end = rest.find('\n');
    const std::string_view text = trim(rest.substr(0, end));
    const bool has_newline = end != std::string_view::npos;
    if (!text.empty() && text.front() != '#') lines_.push_back({number, text, false, has_newline});
    if (!text.empty() && text.front() == '#' && lines_.empty()) head_ = trim(text.substr(1));
    rest.remove_prefix(has_newline ? end + 1 : rest.size());
  }
  if (!lines_.empty()) lines_.back().is_last = true;
}

void TextFile::fail(const TextLine& line, const std::string& what, const std::string& advice) const {
  throw Error(what, path_ + ":" + std::to_string(line.number), advice);
}

std::string_view trim(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\n\v\f";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::vector<std::string_view> split_fields(std::string_view text, bool commas) {
  const std::string_view separators = commas ? " \t\r," : " \t\r";
  std::vector<std::string_view> fields;
  std::size_t begin = text.find_first_not_of(separators);
  while (begin != std::string_view::npos) {
    const std::size_t end = text.find_first_of(separators, begin);
    fields.push_back(text.substr(begin, end - begin));
    begin = text.find_first_not_of(separators, end);
  }
  return fields;
}

std::optional<double> parse_double(std::string_view text) {
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<long long> parse_unsigned(std::string_view text) {
  long long value = 0;
  if (text.empty() || text.front() == '-') return std::nullopt;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace plumbline
