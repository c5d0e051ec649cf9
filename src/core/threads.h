// How many threads the process may have. Header-only, so that `core` itself does not need oneTBB: a folder that
// includes it links `TBB::tbb`.
#pragma once

#include <tbb/global_control.h>

#include <algorithm>
#include <cstddef>

namespace plumbline {

/// `count` or as many as the process may have (affinity, an enclosing limit), at least 1. More are not to be had, and
/// oneTBB prints a warning when an arena asks for them.
inline int allowed_threads(int count) {
  const std::size_t limit = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  return static_cast<int>(std::min(static_cast<std::size_t>(std::max(count, 1)), std::max<std::size_t>(limit, 1)));
}

}  // namespace plumbline
