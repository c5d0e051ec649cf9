// The CPU backend: oneTBB threads over SIMD lanes, the instruction set chosen when the program runs.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "backend/backend.h"

namespace plumbline {

/// `instruction_set` of "" takes the widest that this processor has; see cpu_instruction_sets().
/// Throws Error for one that is unknown or that the processor lacks.
std::unique_ptr<Backend> make_cpu_backend(int threads, const std::string& instruction_set = "");

/// Those compiled in that this processor has, the widest first: "avx2+fma", "sse4.2".
std::vector<std::string> cpu_instruction_sets();
std::string cpu_description();

}  // namespace plumbline
