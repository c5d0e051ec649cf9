// Recordings that are known and not read.
#pragma once

#include <optional>
#include <string>

namespace plumbline {

struct KnownFormat {
  std::string what;  ///< "an OpenNI recording"
  std::string how_to_convert;
};

/// Told by the file's name. Empty for names that say nothing.
std::optional<KnownFormat> known_unread_format(const std::string& path);

}  // namespace plumbline
