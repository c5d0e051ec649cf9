#include "io/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "plumbline/error.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBufferBytes = 1 << 20;

std::string advice_for(int error) {
  switch (error) {
    case ENOSPC:
    case EDQUOT:
      return "free some space or write to another disk";
    case EFBIG:
      return "raise the limit on file sizes (ulimit -f) or write to another file system";
    case ENOENT:
      return "create the folder first";
    case EACCES:
    case EPERM:
    case EROFS:
      return "choose a place that you may write to";
    default:
      return "check the path and the disk";
  }
}

/// Where a link leads, even if nothing is there yet; other paths unchanged.
std::string follow_links(const std::string& path) {
  fs::path target = path;
  std::error_code error;
  // 40 is Linux's own limit on links in a row.
  for (int i = 0; i < 40 && fs::is_symlink(target, error); ++i) {
    const fs::path next = fs::read_symlink(target, error);
    if (error) break;
    target = next.is_absolute() ? next : target.parent_path() / next;
  }
  return target.string();
}

bool is_under(const std::string& path, std::string_view folder) { return path.starts_with(folder); }

/// An old file's permissions outlive its replacement.
void copy_mode(const std::string& target, int fd) {
  struct stat status {};
  if (stat(target.c_str(), &status) != 0) return;
  // A file system without permissions refuses this; the new file is then as good as the old.
  [[maybe_unused]] const int ignored = fchmod(fd, status.st_mode & 07777);
}

/// A rename is on the disk once the folder is. Some file systems cannot sync a folder; the file itself is safe there.
void sync_folder_of(const std::string& file) {
  const fs::path parent = fs::path(file).parent_path();
  const int fd = open(parent.empty() ? "." : parent.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  fsync(fd);
  close(fd);
}

}  // namespace

void throw_write_error(const std::string& path, int error) {
  const bool full = error == ENOSPC || error == EDQUOT;
  throw Error(
      full ? std::string("no space left to write the file") : std::string("cannot be written: ") + std::strerror(error),
      path, advice_for(error));
}

void write_fully(int fd, std::string_view bytes, const std::string& path) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) throw_write_error(path, n < 0 ? errno : ENOSPC);
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
}

void ensure_directory(const std::string& path) {
  std::error_code error;
  const fs::path folder = path.empty() ? fs::path(".") : fs::path(path);
  if (fs::exists(folder, error) && !fs::is_directory(folder, error))
    throw Error("is a file, where a folder is to be made", path, "choose another name or remove the file");
  fs::create_directories(folder, error);
  if (error) throw Error("the folder cannot be made: " + error.message(), path, advice_for(error.value()));
  if (access(folder.c_str(), W_OK | X_OK) != 0)
    throw Error(std::string("the folder cannot be written to: ") + std::strerror(errno), path,
                "choose a folder that you may write to");
}

AtomicFile::AtomicFile(const std::string& path, Durable durable)
    : path_(path), target_(follow_links(path)), durable_(durable) {
  struct stat status {};
  const bool exists = stat(path.c_str(), &status) == 0;
  if (exists && S_ISDIR(status.st_mode))
    throw Error("is a folder, where a file is to be written", path, "give a file name in it");
  direct_ = (exists && !S_ISREG(status.st_mode)) || is_under(path, "/dev/") || is_under(path, "/proc/");
  written_ = direct_ ? path : target_ + ".partial";
  // Opening the partial file does not ask whether the old one may be changed, so a protected file is asked here.
  if (!direct_ && exists && access(target_.c_str(), W_OK) != 0) throw_write_error(path_, errno);
  fd_ = open(written_.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY | (direct_ ? 0 : O_CREAT | O_TRUNC), 0666);
  if (fd_ < 0) throw_write_error(path_, errno);
  if (!direct_ && exists) copy_mode(target_, fd_);
  buffer_.reserve(kBufferBytes);
}

AtomicFile::~AtomicFile() { discard(); }

void AtomicFile::discard() noexcept {
  if (fd_ < 0) return;
  close(fd_);
  fd_ = -1;
  if (!direct_) unlink(written_.c_str());
}

void AtomicFile::write(const void* data, std::size_t bytes) {
  const std::string_view view(static_cast<const char*>(data), bytes);
  if (buffer_.size() + bytes > kBufferBytes) flush();
  if (bytes >= kBufferBytes) {
    write_fully(fd_, view, path_);
  } else {
    buffer_.append(view);
  }
}

void AtomicFile::flush() {
  write_fully(fd_, buffer_, path_);
  buffer_.clear();
}

void AtomicFile::sync_and_close() {
  if (!direct_ && durable_ == Durable::yes && fsync(fd_) != 0) throw_write_error(path_, errno);
  const int fd = fd_;
  fd_ = -1;
  // Network file systems report a full disk only here.
  if (close(fd) != 0) {
    const int error = errno;
    if (!direct_) unlink(written_.c_str());
    throw_write_error(path_, error);
  }
}

void AtomicFile::commit() {
  if (fd_ < 0) throw Error("the file was committed twice", path_, "call commit() once");
  flush();
  sync_and_close();
  if (direct_) return;
  if (std::rename(written_.c_str(), target_.c_str()) != 0) {
    const int error = errno;
    unlink(written_.c_str());
    throw_write_error(path_, error);
  }
  if (durable_ == Durable::yes) sync_folder_of(target_);
}

void write_file(const std::string& path, std::string_view text) {
  AtomicFile file(path);
  file.write(text);
  file.commit();
}

}  // namespace plumbline
