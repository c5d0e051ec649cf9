#include "io/text_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <utility>

#include "core/error.h"
#include "io/gzip.h"

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
  if (is_gzip(bytes)) bytes = gunzip(bytes, path);
  content_ = std::make_shared<const std::string>(std::move(bytes));
  std::string_view rest = *content_;
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
  lines_.reserve(static_cast<std::size_t>(std::count(rest.begin(), rest.end(), '\n')) + 1);
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
  const auto is_separator = [commas](char c) { return c == ' ' || c == '\t' || c == '\r' || (commas && c == ','); };
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
