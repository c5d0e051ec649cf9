// What cuda.cu and launch.cuh use of CUDA (the runtime, cooperative groups, CUB, Thrust, libcu++), for a C++ compiler
// and a device that tests/simulated_device simulates. The headers in include/ lead here. Names and signatures are those
// of the CUDA Runtime API and of CUB's documentation; what is not used is not here.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#define __host__
#define __device__
#define __global__
#define __grid_constant__
#define __launch_bounds__(...)
#define __noinline__ __attribute__((noinline))  // after the standard library's headers, which use it as a name
// One copy a process, which the simulation gives to one block at a time; without a size it is memory of the launch.
#define __shared__ thread_local

struct uint3 {
  unsigned x, y, z;
};
struct dim3 {
  unsigned x, y, z;
  constexpr dim3(unsigned x_ = 1, unsigned y_ = 1, unsigned z_ = 1) : x(x_), y(y_), z(z_) {}
};

// ---- host: the runtime ----------------------------------------------------------------------------------------------

enum cudaError_t {
  cudaSuccess = 0,
  cudaErrorInvalidValue = 1,
  cudaErrorMemoryAllocation = 2,
  cudaErrorInvalidConfiguration = 9,
  cudaErrorNoDevice = 100,
  cudaErrorIllegalAddress = 700,
  cudaErrorCooperativeLaunchTooLarge = 720,
  cudaErrorLaunchFailure = 719
};
enum cudaMemcpyKind { cudaMemcpyHostToDevice = 1, cudaMemcpyDeviceToHost = 2, cudaMemcpyDeviceToDevice = 3 };
enum cudaDeviceAttr { cudaDevAttrCooperativeLaunch = 95 };
constexpr unsigned cudaEventDefault = 0, cudaEventDisableTiming = 2, cudaStreamNonBlocking = 1;

struct cudaDeviceProp {
  char name[256];
  int multiProcessorCount;
};

namespace plumbline::simulated {
struct Event;
struct Stream;
}  // namespace plumbline::simulated
using cudaEvent_t = plumbline::simulated::Event*;
using cudaStream_t = plumbline::simulated::Stream*;

enum cudaLaunchAttributeID { cudaLaunchAttributeCooperative = 2 };
union cudaLaunchAttributeValue {
  int cooperative;
};
struct cudaLaunchAttribute {
  cudaLaunchAttributeID id;
  cudaLaunchAttributeValue val;
};
struct cudaLaunchConfig_t {
  dim3 gridDim, blockDim;
  std::size_t dynamicSmemBytes;
  cudaStream_t stream;
  cudaLaunchAttribute* attrs;
  unsigned numAttrs;
};

const char* cudaGetErrorString(cudaError_t status);
cudaError_t cudaGetLastError();
cudaError_t cudaDriverGetVersion(int* version);
cudaError_t cudaGetDeviceCount(int* count);
cudaError_t cudaGetDeviceProperties(cudaDeviceProp* properties, int device);
cudaError_t cudaDeviceGetAttribute(int* value, cudaDeviceAttr attribute, int device);
cudaError_t cudaMalloc(void** address, std::size_t bytes);
cudaError_t cudaMemGetInfo(std::size_t* free, std::size_t* total);
cudaError_t cudaMallocHost(void** address, std::size_t bytes);
cudaError_t cudaMallocManaged(void** address, std::size_t bytes);
cudaError_t cudaFree(void* address);
cudaError_t cudaFreeHost(void* address);
cudaError_t cudaEventCreateWithFlags(cudaEvent_t* event, unsigned flags);
cudaError_t cudaEventDestroy(cudaEvent_t event);
cudaError_t cudaEventRecord(cudaEvent_t event, cudaStream_t stream);
cudaError_t cudaEventSynchronize(cudaEvent_t event);
cudaError_t cudaEventElapsedTime(float* milliseconds, cudaEvent_t begin, cudaEvent_t end);
cudaError_t cudaStreamCreateWithFlags(cudaStream_t* stream, unsigned flags);
cudaError_t cudaStreamDestroy(cudaStream_t stream);
cudaError_t cudaStreamSynchronize(cudaStream_t stream);
cudaError_t cudaStreamWaitEvent(cudaStream_t stream, cudaEvent_t event, unsigned flags);
cudaError_t cudaMemcpyAsync(void* to, const void* from, std::size_t bytes, cudaMemcpyKind kind, cudaStream_t stream);
cudaError_t cudaMemcpy2DAsync(void* to, std::size_t to_pitch, const void* from, std::size_t from_pitch,
                              std::size_t row_bytes, std::size_t rows, cudaMemcpyKind kind, cudaStream_t stream);
cudaError_t cudaMemsetAsync(void* address, int value, std::size_t bytes, cudaStream_t stream);

namespace plumbline::simulated {

/// A kernel and its arguments, as they were when it was launched: what the device calls its parameters.
class Call {
 public:
  Call() = default;
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;
  virtual ~Call() = default;
  virtual void run() const = 0;  ///< one thread's work
  virtual std::size_t bytes() const = 0;
};

template <class... Parameters>
class CallOf final : public Call {
 public:
  template <class... Arguments>
  explicit CallOf(void (*kernel)(Parameters...), Arguments&&... arguments)
      : kernel_(kernel), arguments_(std::forward<Arguments>(arguments)...) {}
  void run() const override { std::apply(kernel_, arguments_); }
  std::size_t bytes() const override { return sizeof *this; }

 private:
  void (*kernel_)(Parameters...);
  std::tuple<Parameters...> arguments_;
};

cudaError_t launch(const cudaLaunchConfig_t& config, const void* kernel, std::unique_ptr<const Call> call);

/// A library's work, a function object.
template <class Work>
class Algorithm final : public Call {
 public:
  explicit Algorithm(const Work& work) : work_(work) {}
  void run() const override { work_(); }
  std::size_t bytes() const override { return sizeof *this; }

 private:
  Work work_;
};
/// On one thread; its memory is checked as a kernel's is.
cudaError_t launch_algorithm(const char* name, std::unique_ptr<const Call> call, cudaStream_t stream);
template <class Work>
cudaError_t launch_algorithm(const char* name, const Work& work, cudaStream_t stream) {
  return launch_algorithm(name, std::unique_ptr<const Call>(std::make_unique<Algorithm<Work>>(work)), stream);
}

cudaError_t occupancy(int* blocks, int threads, std::size_t shared_bytes);

}  // namespace plumbline::simulated

template <class... Parameters, class... Arguments>
cudaError_t cudaLaunchKernelEx(const cudaLaunchConfig_t* config, void (*kernel)(Parameters...),
                               Arguments&&... arguments) {
  using Call = plumbline::simulated::CallOf<Parameters...>;
  return plumbline::simulated::launch(*config, reinterpret_cast<const void*>(kernel),
                                      std::make_unique<Call>(kernel, std::forward<Arguments>(arguments)...));
}

template <class Kernel>
cudaError_t cudaOccupancyMaxActiveBlocksPerMultiprocessor(int* blocks, Kernel*, int threads, std::size_t shared_bytes) {
  return plumbline::simulated::occupancy(blocks, threads, shared_bytes);
}

// ---- device: what a kernel calls ------------------------------------------------------------------------------------

namespace plumbline::simulated {

// Constant for a thread, whatever runs between two of its calls; of an axis, 0 … 2.
[[gnu::const]] unsigned thread_index(int axis);
[[gnu::const]] unsigned block_index(int axis);
[[gnu::const]] unsigned block_size(int axis);
[[gnu::const]] unsigned grid_size(int axis);

template <unsigned (*Read)(int)>
struct Triple {
  template <int Axis>
  struct Component {
    operator unsigned() const { return Read(Axis); }
  };
  Component<0> x;
  Component<1> y;
  Component<2> z;
};

// In lane order, as CUB's shuffles add; the other lanes than 0 get no number.
float sum_of_warp(float value, const void* storage);
double sum_of_warp(double value, const void* storage);
/// What the threads before this one have, added up, and what all have.
long long sum_before(long long value, long long* total, const void* storage);

void wait_for_grid();

}  // namespace plumbline::simulated

inline constexpr plumbline::simulated::Triple<plumbline::simulated::thread_index> threadIdx;
inline constexpr plumbline::simulated::Triple<plumbline::simulated::block_index> blockIdx;
inline constexpr plumbline::simulated::Triple<plumbline::simulated::block_size> blockDim;
inline constexpr plumbline::simulated::Triple<plumbline::simulated::grid_size> gridDim;

void __syncthreads();
int __syncthreads_or(int predicate);
void __syncwarp(unsigned lanes = 0xffffffffU);
int atomicAdd(int* address, int value);
int atomicMin(int* address, int value);
int atomicMax(int* address, int value);
inline int min(int a, int b) { return b < a ? b : a; }

namespace cooperative_groups {

struct grid_group {
  void sync() const { plumbline::simulated::wait_for_grid(); }
};
inline grid_group this_grid() { return {}; }

}  // namespace cooperative_groups

// ---- libraries ------------------------------------------------------------------------------------------------------

namespace thrust {

template <class T>
class counting_iterator {
 public:
  explicit counting_iterator(T first) : first_(first) {}
  T operator[](std::ptrdiff_t i) const { return first_ + static_cast<T>(i); }

 private:
  T first_;
};

}  // namespace thrust

namespace cuda::std {

template <class = void>
struct plus {
  template <class T>
  constexpr T operator()(const T& a, const T& b) const {
    return a + b;
  }
};

}  // namespace cuda::std

namespace cub {

template <class T>
class WarpReduce {
 public:
  struct TempStorage {
    char bytes[4];
  };
  explicit WarpReduce(TempStorage& storage) : storage_(storage) {}
  T Sum(T value) const { return plumbline::simulated::sum_of_warp(value, &storage_); }

 private:
  TempStorage& storage_;
};

template <class T, int Threads>
class BlockScan {
 public:
  struct TempStorage {
    T values[Threads];
  };
  explicit BlockScan(TempStorage& storage) : storage_(storage) {}
  void ExclusiveSum(T value, T& before, T& total) const {
    T sum = 0;
    before = plumbline::simulated::sum_before(value, &sum, &storage_);
    total = sum;
  }

 private:
  TempStorage& storage_;
};

/// Asked with null for the memory that it needs, each algorithm says how much; it then overwrites it.
inline bool only_says_size(void* memory, std::size_t& bytes) {
  if (memory == nullptr) bytes = 767;
  return memory == nullptr;
}
inline void overwrite(void* memory, std::size_t bytes) {
  for (std::size_t i = 0; i < bytes; ++i) static_cast<volatile char*>(memory)[i] = 1;
}

struct DeviceSelect {
  template <class In, class Flags, class Out, class Count>
  static cudaError_t Flagged(void* memory, std::size_t& bytes, In in, Flags flags, Out out, Count* selected, int count,
                             cudaStream_t stream) {
    if (only_says_size(memory, bytes)) return cudaSuccess;
    const auto work = [=, size = bytes] {
      overwrite(memory, size);
      int next = 0;
      for (int i = 0; i < count; ++i) {
        if (flags[i] != 0) out[next++] = in[i];
      }
      *selected = next;
    };
    return plumbline::simulated::launch_algorithm("cub::DeviceSelect", work, stream);
  }
};

struct DeviceReduce {
  template <class In, class Out, class Add, class Transform, class T>
  static cudaError_t TransformReduce(void* memory, std::size_t& bytes, In in, Out out, int count, Add add,
                                     Transform transform, T initial, cudaStream_t stream) {
    if (only_says_size(memory, bytes)) return cudaSuccess;
    const auto work = [=, size = bytes] {
      overwrite(memory, size);
      T sum = initial;
      for (int i = 0; i < count; ++i) sum = add(sum, static_cast<T>(transform(in[i])));
      *out = sum;
    };
    return plumbline::simulated::launch_algorithm("cub::DeviceReduce", work, stream);
  }
};

struct DeviceScan {
  template <class In, class Out>
  static cudaError_t ExclusiveSum(void* memory, std::size_t& bytes, In in, Out out, int count, cudaStream_t stream) {
    if (only_says_size(memory, bytes)) return cudaSuccess;
    const auto work = [=, size = bytes] {
      overwrite(memory, size);
      auto sum = in[0];
      sum = 0;
      for (int i = 0; i < count; ++i) {
        const auto value = in[i];
        out[i] = sum;
        sum = static_cast<decltype(sum)>(static_cast<unsigned>(sum) + static_cast<unsigned>(value));
      }
    };
    return plumbline::simulated::launch_algorithm("cub::DeviceScan", work, stream);
  }
};

}  // namespace cub
