#include "cli/short_names.h"

#include <algorithm>

namespace plumbline::app {

std::vector<std::string> short_names(std::vector<std::string> paths) {
  if (paths.size() < 2) return paths;
  const auto shared = [&](auto&& condition) { return std::all_of(paths.begin(), paths.end(), condition); };
  for (std::size_t slash = 0; (slash = paths[0].find('/')) != std::string::npos;) {
    const std::string head = paths[0].substr(0, slash + 1);
    if (!shared([&](const std::string& path) { return path.starts_with(head); })) break;
    for (std::string& path : paths) path.erase(0, head.size());
  }
  const std::size_t slash = paths[0].rfind('/');
  if (slash == std::string::npos) return paths;
  const std::string tail = paths[0].substr(slash);
  if (shared([&](const std::string& path) { return path.ends_with(tail) && path.size() > tail.size(); }))
    for (std::string& path : paths) path.erase(path.size() - tail.size());
  return paths;
}

}  // namespace plumbline::app
