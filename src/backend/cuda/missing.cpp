// In the place of cuda.cu where the program is built without nvcc.
#include "backend/cuda/cuda.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

constexpr const char* kReason = "this program was built without the CUDA backend";

}  // namespace

std::unique_ptr<Backend> make_cuda_backend(CudaMemory) {
  throw Error(kReason, "cuda", "install nvcc and build again, or use the cpu backend");
}

BackendInfo cuda_info() { return {"cuda", false, kReason}; }

}  // namespace plumbline
