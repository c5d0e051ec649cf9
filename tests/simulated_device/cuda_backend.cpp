// The very sources of the CUDA backend, for the simulated device. What the compiler makes of copies stays visible, too.
#include <cstddef>
extern "C" {
void* memcpy(void* to, const void* from, std::size_t bytes) noexcept asm("simulated_memcpy");
void* memmove(void* to, const void* from, std::size_t bytes) noexcept asm("simulated_memmove");
void* memset(void* to, int value, std::size_t bytes) noexcept asm("simulated_memset");
}

#include "backend/cuda/cuda.cu"
