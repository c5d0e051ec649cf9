// The launchers: how a kernel meets the threads of a GPU. No maths here.
#pragma once

#include <cstdint>
#include <cub/block/block_scan.cuh>
#include <cub/warp/warp_reduce.cuh>

#include "kernels/lane.h"
#include "kernels/raycast.h"
#include "kernels/volume_view.h"

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

/// A block updates one listed brick, a thread a voxel, first making sure that it has or gets a surface.
template <class Kernel>
__global__ void __launch_bounds__(kernels::kBrickVoxels) for_each_brick(Kernel kernel, const std::int32_t* list) {
  const int brick = list[blockIdx.x], voxel = static_cast<int>(threadIdx.x);
  std::int32_t* occupied = kernel.volume.occupied + brick;
  // The same for the whole block: it is written below only once all of its threads have read it here.
  if (*occupied == 0) {
    if (__syncthreads_or(kernel.template is_near_surface<float>(brick, voxel)) == 0) return;
  }
  const bool solid = __syncthreads_or(kernel.template update<float>(brick, voxel)) != 0;
  if (voxel == 0) *occupied = solid ? kernels::kBrickSolid : kernels::kBrickFree;
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

/// Sums of N slots a block into `partial`, and counts into `histogram` (integers: their order does not matter).
template <int N, class Kernel>
__global__ void __launch_bounds__(kReduceThreads)
    reduce(Kernel kernel, int width, int pixels, double* partial, std::int32_t* histogram, int bins) {
  extern __shared__ std::int32_t counts[];
  constexpr int kWarps = kReduceThreads / kWarp;
  __shared__ float warp_sums[N][kWarps];
  using WarpReduce = cub::WarpReduce<float>;
  __shared__ typename WarpReduce::TempStorage storage[kWarps];

  const int thread = static_cast<int>(threadIdx.x), warp = thread / kWarp;
  for (int bin = thread; bin < bins; bin += kReduceThreads) counts[bin] = 0;
  __syncthreads();

  ThreadSums<N> sums;
  for (float& slot : sums.slots) slot = 0;
  sums.histogram = counts;
  for (int k = 0; k < kPixelsPerThread; ++k) {
    const int pixel = static_cast<int>(blockIdx.x) * kReducePixels + k * kReduceThreads + thread;
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
    partial[static_cast<std::ptrdiff_t>(blockIdx.x) * N + thread] = sum;
  }
  for (int bin = thread; bin < bins; bin += kReduceThreads) {
    if (counts[bin] != 0) atomicAdd(histogram + bin, counts[bin]);
  }
}

/// One block folds what `reduce` left, a warp a slot, always in the same order; the histogram is moved to `counts` and
/// cleared for the next pass. `sums` and `counts` are memory of the host that the device can write.
template <int N>
__global__ void __launch_bounds__(N* kWarp)
    fold(const double* partial, int blocks, std::int32_t* histogram, int bins, double* sums, std::int32_t* counts) {
  using WarpReduce = cub::WarpReduce<double>;
  __shared__ typename WarpReduce::TempStorage storage[N];
  const int slot = static_cast<int>(threadIdx.x) / kWarp, lane = static_cast<int>(threadIdx.x) % kWarp;
  double sum = 0;
  for (int block = lane; block < blocks; block += kWarp) sum += partial[static_cast<std::ptrdiff_t>(block) * N + slot];
  sum = WarpReduce(storage[slot]).Sum(sum);
  if (lane == 0) sums[slot] = sum;
  for (int bin = static_cast<int>(threadIdx.x); bin < bins; bin += N * kWarp) {
    counts[bin] = histogram[bin];
    histogram[bin] = 0;
  }
}

/// Widens the spans of the tiles that a brick covers. Depths are positive, so that their bits are in their order, and
/// neither a least nor a greatest depends on the order of threads.
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
  const int bricks = kernel.volume.bricks;
  const int x = static_cast<int>(blockIdx.x * kTileColumns + threadIdx.x);
  const int row = static_cast<int>(blockIdx.y * kTileRows + threadIdx.y);
  ThreadTiles tiles{kernel.spans};
  if (x < bricks && row < bricks * bricks) kernel.template operator()<float>(x, row, tiles);
}

constexpr int kScanThreads = 256;

/// Inclusive sums along each row of an image, a block a row. Unsigned, as they may wrap.
__global__ void __launch_bounds__(kScanThreads) scan_rows(std::uint32_t* data, int width, int stride) {
  using BlockScan = cub::BlockScan<std::uint32_t, kScanThreads>;
  __shared__ typename BlockScan::TempStorage storage;
  std::uint32_t* row = data + static_cast<std::ptrdiff_t>(blockIdx.x) * stride;
  std::uint32_t before = 0;
  for (int x0 = 0; x0 < width; x0 += kScanThreads) {
    const int x = x0 + static_cast<int>(threadIdx.x);
    std::uint32_t value = x < width ? row[x] : 0, total = 0;
    BlockScan(storage).InclusiveSum(value, value, total);
    if (x < width) row[x] = before + value;
    before += total;
    __syncthreads();
  }
}

/// Inclusive sums down each column, a thread a column.
__global__ void scan_columns(std::uint32_t* data, int width, int height, int stride) {
  const int x = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
  if (x >= width) return;
  std::uint32_t sum = 0;
  for (int y = 0; y < height; ++y) {
    std::uint32_t* value = data + static_cast<std::ptrdiff_t>(y) * stride + x;
    sum += *value;
    *value = sum;
  }
}

}  // namespace plumbline::cuda
