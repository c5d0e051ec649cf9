// Function qualifiers shared by every kernel, so that one source compiles for the CPU's lanes and for a GPU's threads.
#pragma once

#if defined(__CUDACC__)
#define PL_HD __host__ __device__ __forceinline__
#elif defined(__OPTIMIZE__)
// Kernels are compiled once per instruction set. An inline function that is *not* inlined would be emitted as a weak
// symbol in each of those objects, and the linker could keep the one that older processors cannot run.
#define PL_HD inline __attribute__((always_inline))
#else
#define PL_HD inline
#endif

/// Of double-precision maths outside of the lanes' kernels that host and device share.
#if defined(__CUDACC__)
#define PL_SHARED __host__ __device__ inline
#else
#define PL_SHARED inline
#endif
