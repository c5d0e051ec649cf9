// Files that grow line by line and are good up to their last line whatever happens.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace plumbline {

/// Every append() is handed to the system at once, so a killed program loses none of it; what sync() has waited for
/// outlives a loss of power. Not thread-safe.
class AppendFile {
 public:
  /// Makes a new file. Throws Error if there is one already, or it cannot be made.
  explicit AppendFile(const std::string& path);
  ~AppendFile();
  AppendFile(const AppendFile&) = delete;
  AppendFile& operator=(const AppendFile&) = delete;

  /// Whole lines. If the disk takes only a part of them, the file is cut back to what it was. Throws Error.
  void append(std::string_view lines);
  /// Waits until the disk has everything. Throws Error.
  void sync();

 private:
  std::string path_;
  int fd_ = -1;
  std::int64_t size_ = 0;
};

}  // namespace plumbline
