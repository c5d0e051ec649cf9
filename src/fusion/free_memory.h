// How much memory this process may still take.
#pragma once

#include <cstddef>

namespace plumbline {

/// Bytes, by the system and by the limit of the process's control group; 0 if neither says.
std::size_t free_memory();

}  // namespace plumbline
