// The functions of the CUDA runtime that runtime.h declares.
#include "simulated_device/runtime.h"

#include <dlfcn.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "simulated_device/access.h"
#include "simulated_device/blocks.h"
#include "simulated_device/faults.h"
#include "simulated_device/memory.h"
#include "simulated_device/order.h"
#include "simulated_device/streams.h"

namespace plumbline::simulated {
namespace {

constexpr std::size_t kSharedOfBlock = std::size_t{48} << 10;  ///< bytes, without asking for more
constexpr unsigned kThreadsOfBlock = 1024, kBlocksAcross = 65535;
/// The registers that `register_frame`'s bounds leave a thread let this many of its blocks reside (256 · 3 threads).
constexpr int kThreadsByRegisters = 768;

bool is_on_device(const void* address, std::size_t bytes) {
  Memory& memory = Memory::get();
  const auto begin = reinterpret_cast<std::uintptr_t>(address);
  const Allocation* found = memory.find(begin);
  return found != nullptr && found->space != Space::pinned && begin + bytes <= found->begin + found->bytes;
}

bool is_on_host(const void* address) { return !is_device_address(address); }

cudaError_t refuse(const std::string& sentence, cudaError_t error = cudaErrorInvalidValue) {
  report(sentence);
  return Device::get().returned(error);
}

cudaError_t allocate(Space space, void** address, std::size_t bytes) {
  *address = bytes == 0 ? nullptr : Memory::get().allocate(space, bytes);
  return Device::get().returned(bytes == 0 || *address != nullptr ? cudaSuccess : cudaErrorMemoryAllocation);
}

struct Rows {
  void* to;
  std::size_t to_pitch;
  const void* from;
  std::size_t from_pitch, bytes, count;

  std::byte* to_row(std::size_t row) const { return static_cast<std::byte*>(to) + row * to_pitch; }
  const std::byte* from_row(std::size_t row) const { return static_cast<const std::byte*>(from) + row * from_pitch; }
  std::size_t to_span() const { return (count - 1) * to_pitch + bytes; }
  std::size_t from_span() const { return (count - 1) * from_pitch + bytes; }
};

/// Of memory that may be gone by now.
std::vector<std::byte> read_safely(const Rows& rows) {
  std::vector<std::byte> values(rows.bytes * rows.count);
  for (std::size_t row = 0; row < rows.count; ++row) {
    const iovec to = {values.data() + row * rows.bytes, rows.bytes},
                from = {const_cast<std::byte*>(rows.from_row(row)), rows.bytes};
    if (process_vm_readv(getpid(), &to, 1, &from, 1, 0) != static_cast<ssize_t>(rows.bytes)) return {};
  }
  return values;
}

void copy_now(const Rows& rows) {
  for (std::size_t row = 0; row < rows.count; ++row) {
    access_range(rows.from_row(row), rows.bytes, Access::read, "a copy");
    access_range(rows.to_row(row), rows.bytes, Access::write, "a copy");
    std::memcpy(rows.to_row(row), rows.from_row(row), rows.bytes);
  }
}

cudaError_t copy(const Rows& rows, cudaMemcpyKind kind, cudaStream_t stream) {
  Device& device = Device::get();
  if (!device.knows(stream)) return refuse("a copy on a stream that is not there");
  if (device.error() != cudaSuccess) return device.error();
  if (rows.bytes == 0 || rows.count == 0) return cudaSuccess;
  if (rows.to_pitch < rows.bytes || rows.from_pitch < rows.bytes) return cudaErrorInvalidValue;
  const bool to_device = kind != cudaMemcpyDeviceToHost, from_device = kind != cudaMemcpyHostToDevice;
  if (to_device ? !is_on_device(rows.to, rows.to_span()) : !is_on_host(rows.to))
    return refuse("a copy writes to what is not on its side: " + describe(reinterpret_cast<std::uintptr_t>(rows.to)));
  if (from_device ? !is_on_device(rows.from, rows.from_span()) : !is_on_host(rows.from))
    return refuse("a copy reads what is not on its side: " + describe(reinterpret_cast<std::uintptr_t>(rows.from)));
  const bool is_pageable = !from_device && !Memory::get().contains(reinterpret_cast<std::uintptr_t>(rows.from));
  if (!is_pageable) {
    device.enqueue(stream, {[rows] { copy_now(rows); }, nullptr});
    return cudaSuccess;
  }
  // The copy may be made at any time until the stream is waited for; until then the source must stay as it is.
  device.enqueue(stream, {[rows, before = read_safely(rows)] {
                            if (before.empty() || read_safely(rows) != before)
                              return report("the host changed what a copy to the device was still to read");
                            copy_now(rows);
                          },
                          nullptr});
  return cudaSuccess;
}

std::string name_of_kernel(const void* kernel) {
  const std::string name = name_of(kernel);
  return name.substr(0, name.rfind("+0x"));
}

cudaError_t check_shape(const Shape& shape) {
  const std::size_t threads = std::size_t{shape.block.x} * shape.block.y * shape.block.z;
  if (threads == 0 || threads > kThreadsOfBlock) return cudaErrorInvalidConfiguration;
  if (shape.grid.x == 0 || shape.grid.y == 0 || shape.grid.z == 0) return cudaErrorInvalidConfiguration;
  if (shape.grid.x > 0x7fffffffU || shape.grid.y > kBlocksAcross || shape.grid.z > kBlocksAcross)
    return cudaErrorInvalidConfiguration;
  return shape.dynamic_shared > kSharedOfBlock ? cudaErrorInvalidValue : cudaSuccess;
}

/// Blocks that run at the same time: all that the device holds, or a few, which is enough to mix them.
int blocks_at_a_time(const Shape& shape) {
  int of_processor = 0;
  occupancy(&of_processor, static_cast<int>(shape.block.x * shape.block.y * shape.block.z), shape.dynamic_shared);
  const int resident = std::max(of_processor, 1) * Device::get().model().processors;
  return shape.cooperative ? resident : std::min(resident, 4);
}

void run_kernel(const Shape& shape, const void* kernel, const Call& call) {
  const std::string name = name_of_kernel(kernel);
  Launch launched{name,
                  std::size_t{shape.grid.x} * shape.grid.y * shape.grid.z,
                  static_cast<int>(shape.block.x * shape.block.y * shape.block.z),
                  shape.dynamic_shared,
                  0,
                  shape.cooperative};
  Device& device = Device::get();
  if (!run_blocks(name, shape, blocks_at_a_time(shape), call, device.next_seed(), &launched.touched_shared))
    device.fail(cudaErrorIllegalAddress);
  if (launched.touched_shared + launched.dynamic_shared > kSharedOfBlock)
    report(name + " takes more shared memory than a block has");
  device.note(launched);
}

}  // namespace

cudaError_t launch(const cudaLaunchConfig_t& config, const void* kernel, std::unique_ptr<const Call> call) {
  Device& device = Device::get();
  if (!device.knows(config.stream)) return refuse("a launch on a stream that is not there");
  if (device.error() != cudaSuccess) return device.error();
  Shape shape{config.gridDim, config.blockDim, config.dynamicSmemBytes};
  for (unsigned i = 0; i < config.numAttrs; ++i)
    shape.cooperative = shape.cooperative || config.attrs[i].val.cooperative != 0;
  if (const cudaError_t status = check_shape(shape); status != cudaSuccess) return device.returned(status);
  const std::size_t blocks = std::size_t{shape.grid.x} * shape.grid.y * shape.grid.z;
  if (shape.cooperative && blocks > static_cast<std::size_t>(blocks_at_a_time(shape)))
    return device.returned(cudaErrorCooperativeLaunchTooLarge);
  device.enqueue(config.stream, {[shape, kernel, call = std::shared_ptr<const Call>(std::move(call))] {
                                   run_kernel(shape, kernel, *call);
                                 },
                                 nullptr});
  return cudaSuccess;
}

cudaError_t launch_algorithm(const char* name, std::unique_ptr<const Call> call, cudaStream_t stream) {
  Device& device = Device::get();
  if (!device.knows(stream)) return refuse("an algorithm on a stream that is not there");
  if (device.error() != cudaSuccess) return device.error();
  const auto run = [name, call = std::shared_ptr<const Call>(std::move(call))] {
    std::size_t touched = 0;
    if (!run_blocks(name, {}, 1, *call, 0, &touched)) Device::get().fail(cudaErrorIllegalAddress);
  };
  device.enqueue(stream, {run, nullptr});
  return cudaSuccess;
}

cudaError_t occupancy(int* blocks, int threads, std::size_t shared_bytes) {
  const Limits& limits = Device::get().limits();
  const std::size_t shared = shared_bytes + declared_shared() + limits.shared_reserved;
  const int by_threads = std::min(limits.threads_of_processor, std::max(kThreadsByRegisters, threads)) / threads;
  const int by_shared = static_cast<int>(limits.shared_of_processor / shared);
  *blocks = shared_bytes + declared_shared() > kSharedOfBlock
                ? 0
                : std::min({by_threads, by_shared, limits.blocks_of_processor});
  return cudaSuccess;
}

}  // namespace plumbline::simulated

namespace simulated = plumbline::simulated;
using simulated::Device;

const char* cudaGetErrorString(cudaError_t status) {
  switch (status) {
    case cudaSuccess:
      return "no error";
    case cudaErrorInvalidValue:
      return "invalid argument";
    case cudaErrorMemoryAllocation:
      return "out of memory";
    case cudaErrorInvalidConfiguration:
      return "invalid configuration argument";
    case cudaErrorNoDevice:
      return "no CUDA-capable device is detected";
    case cudaErrorIllegalAddress:
      return "an illegal memory access was encountered";
    case cudaErrorLaunchFailure:
      return "unspecified launch failure";
    case cudaErrorCooperativeLaunchTooLarge:
      return "too many blocks in cooperative launch";
  }
  return "unrecognized error code";
}
cudaError_t cudaGetLastError() { return Device::get().take_told(); }

cudaError_t cudaDriverGetVersion(int* version) {
  *version = Device::get().model().available ? 13000 : 0;
  return cudaSuccess;
}
cudaError_t cudaGetDeviceCount(int* count) {
  *count = Device::get().model().available ? 1 : 0;
  return Device::get().returned(Device::get().model().available ? cudaSuccess : cudaErrorNoDevice);
}
cudaError_t cudaGetDeviceProperties(cudaDeviceProp* properties, int device) {
  if (device != 0 || !Device::get().model().available) return cudaErrorNoDevice;
  std::strncpy(properties->name, "simulated device", sizeof properties->name);
  properties->multiProcessorCount = Device::get().model().processors;
  return cudaSuccess;
}
cudaError_t cudaDeviceGetAttribute(int* value, cudaDeviceAttr, int) {
  *value = Device::get().model().cooperative ? 1 : 0;
  return cudaSuccess;
}

cudaError_t cudaMalloc(void** address, std::size_t bytes) {
  return simulated::allocate(simulated::Space::device, address, bytes);
}
cudaError_t cudaMemGetInfo(std::size_t* free, std::size_t* total) {
  *total = std::size_t{1} << 30;
  *free = *total / 2;
  return cudaSuccess;
}
cudaError_t cudaMallocHost(void** address, std::size_t bytes) {
  return simulated::allocate(simulated::Space::pinned, address, bytes);
}
cudaError_t cudaMallocManaged(void** address, std::size_t bytes) {
  return simulated::allocate(simulated::Space::managed, address, bytes);
}
cudaError_t cudaFree(void* address) {
  if (address == nullptr) return cudaSuccess;
  Device::get().finish_all();
  simulated::Memory& memory = simulated::Memory::get();
  if (memory.free(simulated::Space::device, address) || memory.free(simulated::Space::managed, address))
    return cudaSuccess;
  return simulated::refuse("cudaFree of what cudaMalloc did not give");
}
// Nothing says that it waits for copies under way, so it does not: they are found to touch memory of nobody.
cudaError_t cudaFreeHost(void* address) {
  if (address == nullptr || simulated::Memory::get().free(simulated::Space::pinned, address)) return cudaSuccess;
  return simulated::refuse("cudaFreeHost of what cudaMallocHost did not give");
}

cudaError_t cudaEventCreateWithFlags(cudaEvent_t* event, unsigned) {
  *event = new simulated::Event();
  return cudaSuccess;
}
cudaError_t cudaEventDestroy(cudaEvent_t event) {
  delete event;
  return cudaSuccess;
}
cudaError_t cudaEventRecord(cudaEvent_t event, cudaStream_t stream) {
  if (!Device::get().knows(stream)) return simulated::refuse("an event on a stream that is not there");
  Device::get().record(stream, event);
  return Device::get().error();
}
cudaError_t cudaEventSynchronize(cudaEvent_t event) {
  Device::get().finish(event->mark);
  return Device::get().error();
}
cudaError_t cudaEventElapsedTime(float* milliseconds, cudaEvent_t begin, cudaEvent_t end) {
  if (begin->mark == nullptr || end->mark == nullptr || !begin->mark->reached || !end->mark->reached)
    return cudaErrorInvalidValue;
  *milliseconds = static_cast<float>(end->mark->milliseconds - begin->mark->milliseconds);
  return cudaSuccess;
}
cudaError_t cudaStreamCreateWithFlags(cudaStream_t* stream, unsigned) {
  *stream = Device::get().create_stream();
  return cudaSuccess;
}
cudaError_t cudaStreamDestroy(cudaStream_t stream) {
  Device::get().destroy(stream);
  return cudaSuccess;
}
cudaError_t cudaStreamSynchronize(cudaStream_t stream) {
  if (!Device::get().knows(stream)) return simulated::refuse("waiting for a stream that is not there");
  Device::get().finish(stream);
  return Device::get().error();
}
cudaError_t cudaStreamWaitEvent(cudaStream_t stream, cudaEvent_t event, unsigned) {
  if (!Device::get().knows(stream)) return simulated::refuse("a stream that is not there waits");
  Device::get().wait_for(stream, *event);
  return Device::get().error();
}

cudaError_t cudaMemcpyAsync(void* to, const void* from, std::size_t bytes, cudaMemcpyKind kind, cudaStream_t stream) {
  return simulated::copy({to, bytes, from, bytes, bytes, 1}, kind, stream);
}
cudaError_t cudaMemcpy2DAsync(void* to, std::size_t to_pitch, const void* from, std::size_t from_pitch,
                              std::size_t row_bytes, std::size_t rows, cudaMemcpyKind kind, cudaStream_t stream) {
  return simulated::copy({to, to_pitch, from, from_pitch, row_bytes, rows}, kind, stream);
}
cudaError_t cudaMemsetAsync(void* address, int value, std::size_t bytes, cudaStream_t stream) {
  Device& device = Device::get();
  if (!device.knows(stream)) return simulated::refuse("a stream that is not there");
  if (device.error() != cudaSuccess) return device.error();
  if (bytes == 0) return cudaSuccess;
  if (!simulated::is_on_device(address, bytes))
    return simulated::refuse("memory is cleared that is not the device's: " +
                             simulated::describe(reinterpret_cast<std::uintptr_t>(address)));
  const auto clear = [=] {
    simulated::Memory& memory = simulated::Memory::get();
    simulated::Allocation* whole = memory.find(reinterpret_cast<std::uintptr_t>(address));
    if (whole != nullptr && whole->bytes == bytes && whole->written == 0)
      memory.forget(*whole, simulated::Order::get().stamp(15, false));
    else
      simulated::access_range(address, bytes, simulated::Access::write, "cudaMemset");
    if (whole != nullptr) std::memset(address, value, bytes);
  };
  device.enqueue(stream, {clear, nullptr});
  return cudaSuccess;
}
