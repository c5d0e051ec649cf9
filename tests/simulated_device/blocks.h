// Blocks of a kernel: each thread is a fiber that runs until it has to wait for others.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "simulated_device/memory.h"
#include "simulated_device/runtime.h"

namespace plumbline::simulated {

struct Shape {
  dim3 grid, block;
  std::size_t dynamic_shared = 0;
  bool cooperative = false;
};

/// Runs all blocks of a kernel, at most `resident` at a time, in an order that `random` gives. False if a thread did
/// what ends a kernel: an address of nobody, a barrier that others never reach.
bool run_blocks(const std::string& name, const Shape& shape, int resident, const Call& call, std::uint64_t seed,
                std::size_t* touched_shared);

/// Largest size of the shared memory that a launch sets, bytes (sm_90).
constexpr std::size_t kDynamicShared = 227 * 1024;

/// What the running thread may touch beside the arenas.
struct Running {
  bool in_kernel = false;
  std::uintptr_t stack = 0, shared = 0, parameters = 0, dynamic_shared = 0;
  std::size_t stack_bytes = 0, shared_bytes = 0, parameter_bytes = 0, dynamic_shared_bytes = 0;
};
[[gnu::visibility("hidden")]] extern Running now_running;
inline const Running& running() { return now_running; }
/// What the program was loaded with and cannot be written: constants, which the compiler puts on the device as well.
bool is_constant(std::uintptr_t address);
/// Of a word in shared memory, of the block that runs.
Cell& shared_cell(std::uintptr_t address);
/// Gives the running thread up, and the kernel with it.
[[noreturn]] void abandon();
/// Bytes of shared memory that the kernels declare, all together.
std::size_t declared_shared();

}  // namespace plumbline::simulated
