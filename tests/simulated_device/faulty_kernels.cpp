#include "simulated_device/faulty_kernels.h"

#include <cooperative_groups.h>
#include <cuda_runtime.h>

#include <cstdint>
#include <cub/block/block_scan.cuh>
#include <cub/warp/warp_reduce.cuh>
#include <memory>

namespace plumbline::cuda {

/// Where launch.cuh declares it.
__device__ std::int32_t* memory_of_launch() {
  extern __shared__ std::int32_t counts[];
  return counts;
}

}  // namespace plumbline::cuda

namespace plumbline::simulated {
namespace {

constexpr int kThreads = 64, kValues = 256;

struct Work {
  Mistake mistake;
  const int* values;
  int count;
  int* result;  ///< one, and one for each block
};

/// Blocks sum up, the first one adds what they have.
__global__ void sum_values(Work work) {
  __shared__ int of_thread[kThreads];
  __shared__ int beside[kThreads];
  const int thread = static_cast<int>(threadIdx.x), block = static_cast<int>(blockIdx.x),
            blocks = static_cast<int>(gridDim.x);
  int sum = 0;
  for (int i = block * kThreads + thread; i < work.count; i += blocks * kThreads) sum += work.values[i];
  beside[thread] = thread;
  if (work.mistake != Mistake::missing_warp_barrier) __syncwarp();
  if (beside[thread ^ 1] != (thread ^ 1)) sum = 0;
  of_thread[thread] = sum;
  if (work.mistake == Mistake::barrier_of_some) {
    if (thread < 40) __syncthreads();
  } else if (work.mistake != Mistake::missing_barrier) {
    __syncthreads();
  }
  if (thread == 0) {
    int all = 0;
    for (const int of : of_thread) all += of;
    work.result[1 + block] = all;
  }
  if (work.mistake != Mistake::missing_grid_barrier) cooperative_groups::this_grid().sync();
  if (block == 0 && thread == 0) {
    *work.result = 0;
    for (int b = 0; b < blocks; ++b) *work.result += work.result[1 + b];
  }
}

/// The same by CUB and by counting.
__global__ void sum_otherwise(Work work) {
  std::int32_t* numbers = cuda::memory_of_launch();
  using Scan = cub::BlockScan<long long, kThreads>;
  __shared__ typename Scan::TempStorage storage;
  const int thread = static_cast<int>(threadIdx.x), beyond = work.mistake == Mistake::beyond_the_array ? 1 : 0;
  long long sum = 0, before = 0, all = 0;
  for (int i = thread; i < work.count; i += kThreads) sum += work.values[i + beyond];
  Scan(storage).ExclusiveSum(sum, before, all);
  if (work.mistake != Mistake::storage_used_again) __syncthreads();
  Scan(storage).ExclusiveSum(sum, before, all);
  numbers[thread + (work.mistake == Mistake::beyond_shared_memory ? 1 : 0)] = thread;
  if (work.mistake == Mistake::plain_count)
    ++work.result[1];
  else
    atomicAdd(work.result + 1, 1);
  if (thread == 0) *work.result = static_cast<int>(all);
}

class Program {
 public:
  explicit Program(Mistake mistake) : mistake_(mistake) {
    cudaStreamCreateWithFlags(&work_, cudaStreamNonBlocking);
    cudaStreamCreateWithFlags(&bus_, cudaStreamNonBlocking);
    cudaEventCreateWithFlags(&arrived_, cudaEventDisableTiming);
    cudaMallocHost(reinterpret_cast<void**>(&pinned_), sizeof(int) * kValues);
    cudaMallocHost(reinterpret_cast<void**>(&result_), sizeof(int) * 8);
    cudaMalloc(reinterpret_cast<void**>(&values_), sizeof(int) * kValues);
  }
  ~Program() {
    cudaStreamDestroy(work_);
    cudaStreamDestroy(bus_);
    cudaEventDestroy(arrived_);
    if (mistake_ != Mistake::pinned_freed) cudaFreeHost(pinned_);
    cudaFreeHost(result_);
    if (mistake_ != Mistake::freed) cudaFree(values_);
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  int run() {
    send();
    const Work work{mistake_, mistake_ == Mistake::host_pointer ? on_host_.get() : values_, kValues, result_};
    for (int i = 0; i < 8; ++i) result_[i] = 0;
    launch(work);
    if (mistake_ != Mistake::missing_wait && cudaStreamSynchronize(work_) != cudaSuccess) return -1;
    return *result_;
  }

 private:
  void send() {
    for (int i = 0; i < kValues; ++i) on_host_[static_cast<std::size_t>(i)] = pinned_[i] = i;
    if (mistake_ == Mistake::device_pointer) pinned_[0] += values_[0];
    const bool is_plain = mistake_ == Mistake::source_changed;
    const cudaMemcpyKind kind = mistake_ == Mistake::wrong_side ? cudaMemcpyDeviceToDevice : cudaMemcpyHostToDevice;
    if (mistake_ != Mistake::unwritten)
      cudaMemcpyAsync(values_, is_plain ? on_host_.get() : pinned_, sizeof(int) * kValues, kind, bus_);
    if (is_plain) on_host_[7] = 8;
    if (mistake_ == Mistake::pinned_freed) cudaFreeHost(pinned_);
    cudaEventRecord(arrived_, bus_);
    if (mistake_ != Mistake::missing_event) cudaStreamWaitEvent(work_, arrived_, 0);
    if (mistake_ == Mistake::freed) cudaFree(values_);
  }

  void launch(const Work& work) {
    cudaLaunchAttribute cooperative{};
    cooperative.id = cudaLaunchAttributeCooperative;
    cooperative.val.cooperative = 1;
    cudaLaunchConfig_t config{dim3(1), dim3(kThreads), sizeof(int) * kThreads, work_, &cooperative, 0};
    const bool is_otherwise = mistake_ == Mistake::storage_used_again || mistake_ == Mistake::plain_count ||
                              mistake_ == Mistake::beyond_the_array || mistake_ == Mistake::beyond_shared_memory;
    if (mistake_ == Mistake::none || is_otherwise) cudaLaunchKernelEx(&config, sum_otherwise, work);
    config.gridDim = dim3(3);
    config.numAttrs = 1;
    if (!is_otherwise) cudaLaunchKernelEx(&config, sum_values, work);
  }

  Mistake mistake_;
  std::unique_ptr<int[]> on_host_ = std::make_unique<int[]>(kValues);
  cudaStream_t work_ = nullptr, bus_ = nullptr;
  cudaEvent_t arrived_ = nullptr;
  int *pinned_ = nullptr, *result_ = nullptr, *values_ = nullptr;
};

}  // namespace

int sum_with(Mistake mistake) { return Program(mistake).run(); }

}  // namespace plumbline::simulated
