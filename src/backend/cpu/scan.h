// Compaction and prefix sums over the threads of a CPU backend.
#pragma once

#include <cstdint>

#include "core/thread_pool.h"

namespace plumbline::cpu {

/// See Backend::compact and Backend::scan.
int compact(const ThreadPool& threads, const std::int32_t* flags, int count, std::int32_t* list);
std::int64_t scan(const ThreadPool& threads, std::int32_t* values, int count);

}  // namespace plumbline::cpu
