// The launchers: how a kernel meets the threads of a GPU. No maths here.
#pragma once

#include <cooperative_groups.h>

#include <cstdint>
#include <cub/block/block_scan.cuh>
#include <cub/warp/warp_reduce.cuh>

#include "kernels/brick_map.h"
#include "kernels/lane.h"
#include "kernels/raycast.h"
#include "kernels/registration.h"

namespace plumbline::cuda {

constexpr int kTileColumns = 32, kTileRows = 8;  ///< pixels of a block of for_each
constexpr int kWarp = 32;

/// What one block of a reduction takes. Fixed, so that sums fold in the same order on every device.
constexpr int kReduceThreads = 256, kPixelsPerThread = 4;
constexpr int kReducePixels = kReduceThreads * kPixelsPerThread;

constexpr int divide_up(int value, int by) { return (value + by - 1) / by; }

/// kernel(x, y) for every pixel.
template <class Kernel>
__global__ void __launch_bounds__(kTileColumns* kTileRows) for_each(Kernel kernel, int width, int height) {
  const int x = static_cast<int>(blockIdx.x * kTileColumns + threadIdx.x);
  const int y = static_cast<int>(blockIdx.y * kTileRows + threadIdx.y);
  if (x < width && y < height) kernel.template operator()<float>(x, y);
}

/// kernel(entry) for every entry of a list.
template <class Kernel>
__global__ void for_each_entry(Kernel kernel, int entries) {
  const int entry = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
  if (entry < entries) kernel(entry);
}

/// kernel(x) for every element of a long row.
template <class Kernel>
__global__ void for_each_along(Kernel kernel, int count) {
  const int x = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
  if (x < count) kernel.template operator()<float>(x);
}

/// A block updates the listed bricks in turn, a thread a voxel, first making sure that a brick has or gets a surface.
template <class Kernel>
__device__ void update_bricks(const Kernel& kernel, const std::int32_t* list, int count) {
  const int voxel = static_cast<int>(threadIdx.x);
  for (int entry = static_cast<int>(blockIdx.x); entry < count; entry += static_cast<int>(gridDim.x)) {
    const int brick = list[entry];
    const auto at = kernel.at(brick);
    std::int32_t& state = kernel.volume.state(brick);
    // The same for the whole block: it is written below only once all of its threads have read it here.
    if (state == 0) {
      if (__syncthreads_or(kernel.template is_near_surface<float>(at, voxel)) == 0) continue;
    }
    const bool solid = __syncthreads_or(kernel.template update<float>(at, voxel)) != 0;
    if (voxel == 0) state = solid ? kernels::kBrickSolid : kernels::kBrickFree;
  }
}
/// How many are listed is in the device's memory, so that nobody waits for it.
template <class Kernel>
__global__ void __launch_bounds__(kernels::kBrickVoxels)
    for_each_brick(Kernel kernel, const std::int32_t* list, const std::int32_t* listed) {
  update_bricks(kernel, list, *listed);
}
template <class Kernel>
__global__ void __launch_bounds__(kernels::kBrickVoxels)
    for_each_listed_brick(Kernel kernel, const std::int32_t* list, int count) {
  update_bricks(kernel, list, count);
}

/// N sums of one thread, and the block's histogram.
template <int N>
struct ThreadSums {
  float slots[N];
  std::int32_t* histogram;

  PL_HD void add(int slot, float value) { slots[slot] += value; }
  PL_HD void add_product(int slot, float a, float b) { slots[slot] = kernels::madd(a, b, slots[slot]); }
  __device__ void count(std::int32_t bin) { atomicAdd(histogram + bin, 1); }
};

/// One block: the sums of a chunk's pixels into `partial`, and counts into the block's histogram.
template <int N, class Kernel>
__device__ void reduce_chunk(const Kernel& kernel, int chunk, int width, int pixels, double* partial,
                             std::int32_t* counts) {
  constexpr int kWarps = kReduceThreads / kWarp;
  __shared__ float warp_sums[N][kWarps];
  using WarpReduce = cub::WarpReduce<float>;
  __shared__ typename WarpReduce::TempStorage storage[kWarps];

  const int thread = static_cast<int>(threadIdx.x), warp = thread / kWarp;
  ThreadSums<N> sums;
  for (float& slot : sums.slots) slot = 0;
  sums.histogram = counts;
  for (int k = 0; k < kPixelsPerThread; ++k) {
    const int pixel = chunk * kReducePixels + k * kReduceThreads + thread;
    if (pixel < pixels) kernel.template operator()<float>(pixel % width, pixel / width, sums);
  }
  __syncwarp();
#pragma unroll
  for (int slot = 0; slot < N; ++slot) {
    const float sum = WarpReduce(storage[warp]).Sum(sums.slots[slot]);
    if (thread % kWarp == 0) warp_sums[slot][warp] = sum;
    __syncwarp();
  }
  __syncthreads();

  if (thread < N) {
    double sum = 0;
    for (const float of_warp : warp_sums[thread]) sum += of_warp;
    partial[static_cast<std::ptrdiff_t>(chunk) * N + thread] = sum;
  }
  __syncthreads();  // the next chunk writes warp_sums
}

/// One block: the bins of its histogram.
__device__ inline void clear_bins(std::int32_t* counts, int bins) {
  for (int bin = static_cast<int>(threadIdx.x); bin < bins; bin += static_cast<int>(blockDim.x)) counts[bin] = 0;
}
/// Integers: in which order the blocks add does not matter.
__device__ inline void add_bins(const std::int32_t* counts, int bins, std::int32_t* histogram) {
  for (int bin = static_cast<int>(threadIdx.x); bin < bins; bin += static_cast<int>(blockDim.x)) {
    if (counts[bin] != 0) atomicAdd(histogram + bin, counts[bin]);
  }
}

/// Sums of N slots a block into `partial`, and counts into `histogram`.
template <int N, class Kernel>
__global__ void __launch_bounds__(kReduceThreads)
    reduce(Kernel kernel, int width, int pixels, double* partial, std::int32_t* histogram, int bins) {
  extern __shared__ std::int32_t counts[];
  clear_bins(counts, bins);
  __syncthreads();
  reduce_chunk<N>(kernel, static_cast<int>(blockIdx.x), width, pixels, partial, counts);
  add_bins(counts, bins, histogram);
}

/// One block folds what the chunks left, a warp a slot, in the same order whatever the number of warps.
template <int N, int Warps>
__device__ void fold_chunks(const double* partial, int chunks, double* sums) {
  using WarpReduce = cub::WarpReduce<double>;
  __shared__ typename WarpReduce::TempStorage storage[Warps];
  const int warp = static_cast<int>(threadIdx.x) / kWarp, lane = static_cast<int>(threadIdx.x) % kWarp;
  for (int slot = warp; slot < N; slot += Warps) {
    double sum = 0;
    for (int chunk = lane; chunk < chunks; chunk += kWarp)
      sum += partial[static_cast<std::ptrdiff_t>(chunk) * N + slot];
    sum = WarpReduce(storage[warp]).Sum(sum);
    if (lane == 0) sums[slot] = sum;
    __syncwarp();
  }
}

/// One block folds what `reduce` left; the histogram is moved to `counts` and cleared for the next pass. `sums` and
/// `counts` are memory of the host that the device can write.
template <int N>
__global__ void __launch_bounds__(N* kWarp)
    fold(const double* partial, int chunks, std::int32_t* histogram, int bins, double* sums, std::int32_t* counts) {
  fold_chunks<N, N>(partial, chunks, sums);
  for (int bin = static_cast<int>(threadIdx.x); bin < bins; bin += N * kWarp) {
    counts[bin] = histogram[bin];
    histogram[bin] = 0;
  }
}

/// One block: the bin that holds the median, −1 if nothing was counted; the same for every thread.
__device__ inline int find_median(const std::int32_t* histogram, int bins) {
  using BlockScan = cub::BlockScan<long long, kReduceThreads>;
  __shared__ typename BlockScan::TempStorage storage;
  __shared__ int found;
  const int thread = static_cast<int>(threadIdx.x), each = divide_up(bins, kReduceThreads);
  const int first = min(thread * each, bins), end = min(first + each, bins);
  long long here = 0, below = 0, total = 0;
  for (int bin = first; bin < end; ++bin) here += histogram[bin];
  if (thread == 0) found = -1;
  BlockScan(storage).ExclusiveSum(here, below, total);
  __syncthreads();
  for (int bin = first; bin < end; ++bin) {
    const long long before = below;
    below += histogram[bin];
    if (kernels::holds_median(before, below, total)) found = bin;
  }
  __syncthreads();
  return found;
}

/// Memory of a block for a value that has a constructor.
template <class T>
struct SharedValue {
  alignas(16) unsigned char bytes[sizeof(T)];
  __device__ T& get() { return *reinterpret_cast<T*>(bytes); }
};

/// What `register_frame` keeps in shared memory between the passes.
struct RegistrationBlock {
  SharedValue<kernels::RegistrationPass> next;
  SharedValue<kernels::IcpReduce> pass;
  SharedValue<kernels::IcpCorrection> correction;
  double sums[kernels::icp_sum::kCount];
};

/// One thread's work between two passes. A call of its own, so that its many values do not cost the passes registers.
__device__ __noinline__ void advance_registration(const kernels::Registration& registration, const double* sums,
                                                  int bin, kernels::RegistrationState* state) {
  kernels::advance(registration, sums, bin, state);
}

/// Registers a frame without the host: all blocks sum up a pass, the first one folds it, thread 0 solves and decides
/// what comes next (`kernels::advance`), until nothing is left. To be launched cooperatively: blocks wait for each
/// other twice a pass. Chunks and their order are those of `reduce`, so that both give the same bits.
__global__ void __launch_bounds__(kReduceThreads, 3)
    register_frame(const __grid_constant__ kernels::Registration registration, kernels::RegistrationState* state,
                   double* partial, std::int32_t* histogram) {
  constexpr int kSlots = kernels::icp_sum::kCount, kWarps = kReduceThreads / kWarp;
  extern __shared__ std::int32_t counts[];
  __shared__ RegistrationBlock block;
  const auto grid = cooperative_groups::this_grid();
  const kernels::RegistrationPass& next = block.next.get();
  const bool is_first_thread = threadIdx.x == 0;
  for (;;) {
    if (is_first_thread) {
      block.next.get() = state->next;
      block.pass.get() = {next.in, registration.levels[next.level].distances};
      const PlaneView<float>& d = registration.levels[next.level].distances;
      block.correction.get() = {next.in, next.from_low, next.from_high, {d.data, d.width, d.height, d.stride}};
    }
    __syncthreads();
    if (next.task == kernels::RegistrationTask::finished) return;
    const bool is_correction = next.task == kernels::RegistrationTask::correction;
    const int width = next.in.live_depth.width, pixels = width * next.in.live_depth.height;
    const int chunks = divide_up(pixels, kReducePixels);
    // One bin more counts what lies beyond the range; one more still what is no pair, which nobody asks for.
    const int bins = is_correction || next.in.bins == 0 ? 0 : next.in.bins + 2;
    clear_bins(counts, bins);
    __syncthreads();
    for (int chunk = static_cast<int>(blockIdx.x); chunk < chunks; chunk += static_cast<int>(gridDim.x)) {
      if (is_correction)
        reduce_chunk<kSlots>(block.correction.get(), chunk, width, pixels, partial, counts);
      else
        reduce_chunk<kSlots>(block.pass.get(), chunk, width, pixels, partial, counts);
    }
    add_bins(counts, bins, histogram);
    grid.sync();
    if (blockIdx.x == 0) {
      fold_chunks<kSlots, kWarps>(partial, chunks, block.sums);
      const int bin = find_median(histogram, bins > 0 ? bins - 1 : 0);
      clear_bins(histogram, bins);
      if (is_first_thread) advance_registration(registration, block.sums, bin, state);
    }
    grid.sync();
  }
}

/// Widens the spans of the tiles that a brick covers. Depths are positive, so that their bits are in their order, and
/// neither a minimum nor a maximum depends on the order of threads.
struct ThreadTiles {
  kernels::RaySpanView spans;

  template <class F>
  __device__ void widen(bool valid, const kernels::RayTiles<F>& at, F near, F far) {
    if (!valid) return;
    for (int y = at.y0; y <= at.y1; ++y) {
      for (int x = at.x0; x <= at.x1; ++x) {
        const int tile = y * spans.stride + x;
        atomicMin(reinterpret_cast<int*>(spans.nearest + tile), kernels::bits_from_float(near));
        atomicMax(reinterpret_cast<int*>(spans.farthest + tile), kernels::bits_from_float(far));
      }
    }
  }
};

__global__ void clear_spans(kernels::RaySpanView spans) {
  const int tile = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
  if (tile >= spans.stride * spans.rows) return;
  spans.nearest[tile] = kernels::kNoRange;
  spans.farthest[tile] = 0;
}

__global__ void span_rays(kernels::RaySpans kernel) {
  const int x = static_cast<int>(blockIdx.x * kTileColumns + threadIdx.x);
  const int row = static_cast<int>(blockIdx.y * kTileRows + threadIdx.y);
  ThreadTiles tiles{kernel.spans};
  if (x < kernel.volume.bricks_per_row() && row < kernel.volume.brick_rows())
    kernel.template operator()<float>(x, row, tiles);
}

}  // namespace plumbline::cuda
