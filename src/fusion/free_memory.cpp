#include "fusion/free_memory.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <optional>
#include <string>

namespace plumbline {
namespace {

/// MemAvailable of /proc/meminfo: what is free, or held by caches that give way.
std::optional<std::size_t> system_memory() {
  std::ifstream file("/proc/meminfo");
  std::string name, unit;
  std::size_t kibibytes = 0;
  while (file >> name >> kibibytes) {
    if (name == "MemAvailable:") return kibibytes << 10;
    std::getline(file, unit);
  }
  return std::nullopt;
}

std::optional<std::size_t> number_in(const std::string& path) {
  std::ifstream file(path);
  std::size_t number = 0;
  if (file >> number) return number;
  return std::nullopt;  // "max": no limit
}

/// What a container's limit leaves (control groups, version 2).
std::optional<std::size_t> group_memory() {
  const auto limit = number_in("/sys/fs/cgroup/memory.max"), used = number_in("/sys/fs/cgroup/memory.current");
  if (!limit || !used) return std::nullopt;
  return *limit > *used ? *limit - *used : 0;
}

}  // namespace

std::size_t free_memory() {
  constexpr std::size_t kUnknown = std::numeric_limits<std::size_t>::max();
  const std::size_t free = std::min(system_memory().value_or(kUnknown), group_memory().value_or(kUnknown));
  return free == kUnknown ? 0 : free;
}

}  // namespace plumbline
