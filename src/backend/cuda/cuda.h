// The CUDA backend: the same kernels, one pixel or voxel a thread. It is there where nvcc was found at build time.
#pragma once

#include <memory>

#include "backend/backend.h"

namespace plumbline {

/// Where a backend's memory lies. `managed` can be read by the host as well, as tests do; every call then waits until
/// the device is through.
enum class CudaMemory { device, managed };

/// On the first device. Throws Error where there is none, with the driver's reason.
std::unique_ptr<Backend> make_cuda_backend(CudaMemory memory = CudaMemory::device);

BackendInfo cuda_info();

}  // namespace plumbline
