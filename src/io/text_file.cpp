#include "io/text_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <limits>
#include <utility>

#include "core/huge_pages.h"
#include "io/gzip.h"
#include "plumbline/error.h"

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

/// Bytes whose memory is not cleared before it is read into, which for large files costs as much as the reading.
struct Bytes {
  std::unique_ptr<char[]> data;
  std::size_t size = 0;
  std::size_t capacity = 0;

  explicit Bytes(std::size_t capacity_) : data(new char[capacity_]), capacity(capacity_) {
    prefer_huge_pages(data.get(), capacity);
  }
  std::string_view view() const { return {data.get(), size}; }
};

void grow(Bytes* bytes) {
  Bytes larger(bytes->capacity + 65536);
  std::memcpy(larger.data.get(), bytes->data.get(), bytes->size);
  larger.size = bytes->size;
  *bytes = std::move(larger);
}

/// All of a file, which may be longer or shorter than it said it was, or its first `limit` bytes.
Bytes read_bytes(const std::string& path, std::size_t limit = std::numeric_limits<std::size_t>::max()) {
  const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat status {};
  if (file.fd < 0 || fstat(file.fd, &status) != 0) fail_to_read(path);
  if (S_ISDIR(status.st_mode)) throw Error("is a folder, where a file is expected", path, "give the file in it");
  // One byte more than the size, so that the end is seen without growing the buffer.
  Bytes bytes(std::min(static_cast<std::size_t>(status.st_size) + 1, limit));
  for (;;) {
    if (bytes.size == limit) return bytes;
    if (bytes.size == bytes.capacity) grow(&bytes);
    const ssize_t n = read(file.fd, bytes.data.get() + bytes.size, std::min(bytes.capacity, limit) - bytes.size);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail_to_read(path);
    if (n == 0) return bytes;
    bytes.size += static_cast<std::size_t>(n);
  }
}

}  // namespace

std::string read_file(const std::string& path) { return std::string(read_bytes(path).view()); }

std::string read_beginning(const std::string& path, std::size_t limit) {
  return std::string(read_bytes(path, limit).view());
}

TextFile::TextFile(const std::string& path) : path_(path) {
  Bytes bytes = read_bytes(path);
  std::string_view rest = bytes.view();
  if (is_gzip(rest)) {
    auto unpacked = std::make_shared<const std::string>(gunzip(rest, path));
    rest = *unpacked;
    content_ = std::move(unpacked);
  } else {
    content_ = std::shared_ptr<const char[]>(std::move(bytes.data));
  }
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
  reserve_large(&lines_, static_cast<std::size_t>(std::count(rest.begin(), rest.end(), '\n')) + 1);
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
  const auto is_blank = [](char c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

void split_fields(std::string_view text, bool commas, std::vector<std::string_view>* fields) {
  const auto is_separator = [commas](char c) {
    return c == ' ' || c == '\t' || c == '\r' || (commas && (c == ',' || c == ';'));
  };
  fields->clear();
  const char *at = text.data(), *const end = at + text.size();
  while (true) {
    while (at != end && is_separator(*at)) ++at;
    if (at == end) return;
    const char* const begin = at;
    while (at != end && !is_separator(*at)) ++at;
    fields->emplace_back(begin, static_cast<std::size_t>(at - begin));
  }
}

std::vector<std::string_view> split_fields(std::string_view text, bool commas) {
  std::vector<std::string_view> fields;
  split_fields(text, commas, &fields);
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
