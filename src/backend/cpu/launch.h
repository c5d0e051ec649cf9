// The launchers: how a kernel meets the lanes and the threads. No maths here.
#pragma once

#include <cstdint>

#include "backend/cpu/threads.h"
#include "kernels/lane.h"

namespace plumbline::cpu {

/// Rows of an image that one task takes. Fixed, so that sums fold in the same order for every number of threads.
constexpr int kRowsPerChunk = 8;

/// Calls kernel(x, y) for every pixel, a lane's width at a time.
template <class F, class Kernel>
PL_HD void for_each(const Threads& threads, int width, int height, const Kernel& kernel) {
  threads.run((height + kRowsPerChunk - 1) / kRowsPerChunk, [&](int chunk, int) {
    const int end = (chunk + 1) * kRowsPerChunk < height ? (chunk + 1) * kRowsPerChunk : height;
    for (int y = chunk * kRowsPerChunk; y < end; ++y) {
      for (int x = 0; x < width; x += kernels::Lane<F>::width) kernel.template operator()<F>(x, y);
    }
  });
}

/// Sums of N slots over lanes, and a histogram shared by what one worker does.
template <class F, int N>
struct LaneSums {
  F slots[N];
  std::int32_t* histogram;

  PL_HD void add(int slot, const F& value) { slots[slot] = slots[slot] + value; }
  PL_HD void add_product(int slot, const F& a, const F& b) { slots[slot] = kernels::madd(a, b, slots[slot]); }
  PL_HD void count(const kernels::Int<F>& bin) {
    alignas(64) std::int32_t bins[kernels::Lane<F>::width];
    kernels::store_int(bins, bin);
    for (const std::int32_t b : bins) ++histogram[b];
  }
};

/// Sums the kernel's N slots over all pixels into `sums`, and its counts into `histogram` (`bins` entries). Partial
/// sums are kept per chunk and folded in order, in double: the same bits for any number of threads.
template <class F, int N, class Kernel>
PL_HD void reduce(const Threads& threads, int width, int height, const Kernel& kernel, double* sums,
                  std::int32_t* histogram, int bins) {
  constexpr int kWidth = kernels::Lane<F>::width;
  const int chunks = (height + kRowsPerChunk - 1) / kRowsPerChunk;
  auto* partial = static_cast<double*>(threads.scratch(0, sizeof(double) * N * static_cast<std::size_t>(chunks)));
  auto* counts = static_cast<std::int32_t*>(threads.scratch(
      1, sizeof(std::int32_t) * static_cast<std::size_t>(bins) * static_cast<std::size_t>(threads.count())));
  threads.run(chunks, [&](int chunk, int worker) {
    LaneSums<F, N> local;
    for (F& slot : local.slots) slot = F(0.0f);
    local.histogram = counts + static_cast<std::ptrdiff_t>(worker) * bins;
    const int end = (chunk + 1) * kRowsPerChunk < height ? (chunk + 1) * kRowsPerChunk : height;
    for (int y = chunk * kRowsPerChunk; y < end; ++y) {
      for (int x = 0; x < width; x += kWidth) kernel.template operator()<F>(x, y, local);
    }
    for (int slot = 0; slot < N; ++slot) {
      alignas(64) float lanes[kWidth];
      kernels::store(lanes, local.slots[slot]);
      double sum = 0;
      for (const float lane : lanes) sum += lane;
      partial[static_cast<std::ptrdiff_t>(chunk) * N + slot] = sum;
    }
  });
  for (int slot = 0; slot < N; ++slot) sums[slot] = 0;
  for (int chunk = 0; chunk < chunks; ++chunk) {
    for (int slot = 0; slot < N; ++slot) sums[slot] += partial[static_cast<std::ptrdiff_t>(chunk) * N + slot];
  }
  for (int bin = 0; bin < bins; ++bin) {
    std::int32_t total = 0;
    for (int worker = 0; worker < threads.count(); ++worker)
      total += counts[static_cast<std::ptrdiff_t>(worker) * bins + bin];
    histogram[bin] = total;
  }
}

/// Bricks that one task takes.
constexpr int kBricksPerChunk = 16;

/// Updates the listed bricks, first making sure that those without a surface get one.
template <class F, class Kernel>
PL_HD void for_each_brick(const Threads& threads, const Kernel& kernel, const std::int32_t* list, int count) {
  constexpr int kWidth = kernels::Lane<F>::width;
  threads.run((count + kBricksPerChunk - 1) / kBricksPerChunk, [&](int chunk, int) {
    const int end = (chunk + 1) * kBricksPerChunk < count ? (chunk + 1) * kBricksPerChunk : count;
    for (int i = chunk * kBricksPerChunk; i < end; ++i) {
      const int brick = list[i];
      bool occupied = kernel.volume.occupied[brick] != 0;
      for (int offset = 0; !occupied && offset < kernels::kBrickVoxels; offset += kWidth)
        occupied = kernels::any(kernel.template is_near_surface<F>(brick, offset));
      if (!occupied) continue;
      kernel.volume.occupied[brick] = 1;
      for (int offset = 0; offset < kernels::kBrickVoxels; offset += kWidth) kernel.template update<F>(brick, offset);
    }
  });
}

}  // namespace plumbline::cpu
