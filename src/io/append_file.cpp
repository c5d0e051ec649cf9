#include "io/append_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>

#include "io/atomic_file.h"
#include "plumbline/error.h"

namespace plumbline {

AppendFile::AppendFile(const std::string& path) : path_(path) {
  fd_ = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0666);
  if (fd_ < 0 && errno == EEXIST) throw Error("exists already", path, "choose another folder, or move it away");
  if (fd_ < 0) throw_write_error(path, errno);
}

AppendFile::~AppendFile() { close(fd_); }

void AppendFile::append(std::string_view lines) {
  try {
    write_fully(fd_, lines, path_);
  } catch (const Error&) {
    [[maybe_unused]] const int ignored = ftruncate(fd_, size_);
    throw;
  }
  size_ += static_cast<std::int64_t>(lines.size());
}

void AppendFile::sync() {
  if (fdatasync(fd_) != 0) throw_write_error(path_, errno);
}

}  // namespace plumbline
