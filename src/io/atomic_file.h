// Files that appear whole or not at all.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace plumbline {

/// Creates the folder and those above it where they are missing. Throws Error if the path is a file or the folder
/// cannot be written to.
void ensure_directory(const std::string& path);

/// Whether commit() waits until the bytes lie on the disk. `no` is for one picture among thousands, which can be made
/// again; it is still never seen half-written by another program.
enum class Durable { yes, no };

/// Writes beside the target (`name.partial`) and renames on commit(), so a failure leaves an old file as it was.
///
/// Targets that are not regular files (a pipe, a terminal, anything under /dev or /proc) are written directly. A
/// symbolic link is followed: the file that it names is replaced, the link stays. Not for two writers of one path at
/// a time. Not thread-safe.
class AtomicFile {
 public:
  /// Throws Error if the file cannot be made.
  explicit AtomicFile(const std::string& path, Durable durable = Durable::yes);
  /// Without a commit(): removes the partial file.
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Appends. Throws Error as soon as the system refuses bytes (a full disk, a quota, a limit on file sizes).
  void write(const void* data, std::size_t bytes);
  void write(std::string_view text) { write(text.data(), text.size()); }

  /// Makes the file appear under its name. Throws Error if not every byte could be written; call it once.
  void commit();

 private:
  void flush();
  void sync_and_close();
  void discard() noexcept;

  std::string path_;     // as given: what errors name
  std::string target_;   // with links followed
  std::string written_;  // where the bytes go: target_, or the partial file beside it
  Durable durable_;
  bool direct_ = false;
  int fd_ = -1;
  std::string buffer_;
};

/// A whole file at once. Throws Error as AtomicFile does.
void write_file(const std::string& path, std::string_view text);

/// Throws the Error of a failed system call on a file being written; `error` is its errno.
[[noreturn]] void throw_write_error(const std::string& path, int error);

/// Writes all bytes to an open descriptor, past interruptions and short writes. Throws Error.
void write_fully(int fd, std::string_view bytes, const std::string& path);

}  // namespace plumbline
