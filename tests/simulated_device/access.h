// Every access to memory that cuda.cu and the kernels make (access.cpp is called by what `-fsanitize=thread` puts
// before them) and every copy: whether the address may be touched from where it is, and whether it is in order with
// others.
#pragma once

#include <cstddef>

namespace plumbline::simulated {

enum class Access { read, write, atomic };

/// By the code that runs now, the host's or a thread's. `instruction` names it.
void access(const void* address, std::size_t bytes, Access kind, const void* instruction);
/// By an operation of a stream.
void access_range(const void* address, std::size_t bytes, Access kind, const char* operation);

}  // namespace plumbline::simulated
