// Files from the web that are large and break off.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace plumbline {

struct DownloadProgress {
  std::uint64_t done = 0;   ///< bytes that lie on the disk
  std::uint64_t total = 0;  ///< bytes; 0 where the server does not tell
  int broken = 0;           ///< times that the connection broke off
};

struct DownloadOptions {
  std::string sha256;         ///< that the whole file must have, in hexadecimal; empty: any
  int attempts = 6;           ///< tries in a row that may bring no new byte
  double first_wait = 1;      ///< s before the second of these; doubled each time
  double stall_timeout = 30;  ///< s without a byte after which a connection counts as broken
  /// Called now and then; false stops.
  std::function<bool(const DownloadProgress&)> progress;
};

enum class DownloadResult { complete, stopped };

/// Fetches `url` (http or https, redirects followed) to `path`. What has come lies in `path`.partial until it is whole
/// and its checksum is right; a broken connection is taken up again where it broke off, in this call and in a later
/// one, if the file on the server is still the same (its ETag or date). Throws Error if the server refuses, the file
/// breaks off too often, its length or checksum is wrong (the partial file is then removed), or the disk refuses; and
/// where this program was built without libcurl.
DownloadResult download_file(const std::string& url, const std::string& path, const DownloadOptions& options);

/// SHA-256 of a file's bytes, hexadecimal. Throws Error if it cannot be read.
std::string sha256_of(const std::string& path);

/// Unpacks an archive (tar with any compression, zip) into `folder`, which must not exist: into a folder beside it at
/// first, renamed when all is done. A single folder at the top of the archive is left out. Throws Error if the archive
/// is damaged, or holds names that point out of the folder; nothing is left then. `go_on` false stops with an Error.
void unpack_archive(const std::string& archive, const std::string& folder, const std::function<bool()>& go_on);

}  // namespace plumbline
