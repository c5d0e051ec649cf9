// The launchers: how a kernel meets the lanes and the threads. No maths here.
#pragma once

#include <cstdint>

#include "core/thread_pool.h"
#include "kernels/lane.h"
#include "kernels/raycast.h"

namespace plumbline::cpu {

/// Rows of an image that one task takes. Fixed, so that sums fold in the same order for every number of threads.
constexpr int kRowsPerChunk = 8;

// Every task works on its own copy of the kernel. Stores of vectors may alias anything (so the language has it), and
// what lies behind a reference would be read again, and its quotients divided again, at every pixel.

/// Calls kernel(x, y) for every pixel, a lane's width at a time.
template <class F, class Kernel>
PL_HD void for_each(const ThreadPool& threads, int width, int height, const Kernel& kernel) {
  threads.run((height + kRowsPerChunk - 1) / kRowsPerChunk, [&](int chunk, int) {
    const Kernel own = kernel;
    const int end = (chunk + 1) * kRowsPerChunk < height ? (chunk + 1) * kRowsPerChunk : height;
    for (int y = chunk * kRowsPerChunk; y < end; ++y) {
      for (int x = 0; x < width; x += kernels::Lane<F>::width) own.template operator()<F>(x, y);
    }
  });
}

/// Calls kernel(x) for every element of a long row.
template <class F, class Kernel>
PL_HD void for_each_along(const ThreadPool& threads, int count, const Kernel& kernel) {
  constexpr int kChunk = 4096;
  threads.run((count + kChunk - 1) / kChunk, [&](int chunk, int) {
    const Kernel own = kernel;
    const int end = (chunk + 1) * kChunk < count ? (chunk + 1) * kChunk : count;
    for (int x = chunk * kChunk; x < end; x += kernels::Lane<F>::width) own.template operator()<F>(x);
  });
}

/// Calls kernel(x, y) for every pixel, by blocks of them.
template <class F, class Kernel>
PL_HD void for_each_block(const ThreadPool& threads, int width, int height, const Kernel& kernel) {
  using Block = kernels::Block<F>;
  static_assert(kRowsPerChunk % Block::height == 0);
  threads.run((height + kRowsPerChunk - 1) / kRowsPerChunk, [&](int chunk, int) {
    const Kernel own = kernel;
    const int end = (chunk + 1) * kRowsPerChunk < height ? (chunk + 1) * kRowsPerChunk : height;
    for (int y = chunk * kRowsPerChunk; y < end; y += Block::height) {
      for (int x = 0; x < width; x += Block::width) own.template operator()<F>(x, y);
    }
  });
}

/// Copies of each bin, taken in turn by the lanes: neighbours fall into the same bin, and each count would wait for the
/// one before.
constexpr int kHistogramCopies = 4;

/// Sums of N slots over lanes, and a histogram shared by what one worker does.
template <class F, int N>
struct LaneSums {
  F slots[N];
  std::int32_t* histogram;

  PL_HD void add(int slot, const F& value) { slots[slot] = slots[slot] + value; }
  PL_HD void add_product(int slot, const F& a, const F& b) { slots[slot] = kernels::madd(a, b, slots[slot]); }
  PL_HD void count(const kernels::Int<F>& bin) {
    alignas(64) std::int32_t bins[kernels::Lane<F>::width];
    const auto copy = kernels::Lane<F>::int_index() & kernels::Int<F>(kHistogramCopies - 1);
    kernels::store_int(bins, bin * kernels::Int<F>(kHistogramCopies) + copy);
    for (const std::int32_t b : bins) ++histogram[b];
  }
};

/// Sums the kernel's N slots over all pixels into `sums`, and its counts into `histogram` (`bins` entries). Partial
/// sums are kept per chunk and folded in order, in double: the same bits for any number of threads.
template <class F, int N, class Kernel>
PL_HD void reduce(const ThreadPool& threads, int width, int height, const Kernel& kernel, double* sums,
                  std::int32_t* histogram, int bins) {
  constexpr int kWidth = kernels::Lane<F>::width;
  const int chunks = (height + kRowsPerChunk - 1) / kRowsPerChunk;
  auto* partial = static_cast<double*>(threads.scratch(0, sizeof(double) * N * static_cast<std::size_t>(chunks)));
  auto* counts = static_cast<std::int32_t*>(
      threads.scratch(1, sizeof(std::int32_t) * kHistogramCopies * static_cast<std::size_t>(bins) *
                             static_cast<std::size_t>(threads.count())));
  threads.run(chunks, [&](int chunk, int worker) {
    const Kernel own = kernel;
    LaneSums<F, N> local;
    for (F& slot : local.slots) slot = F(0.0f);
    local.histogram = counts + static_cast<std::ptrdiff_t>(worker) * bins * kHistogramCopies;
    const int end = (chunk + 1) * kRowsPerChunk < height ? (chunk + 1) * kRowsPerChunk : height;
    for (int y = chunk * kRowsPerChunk; y < end; ++y) {
      for (int x = 0; x < width; x += kWidth) own.template operator()<F>(x, y, local);
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
    for (int worker = 0; worker < threads.count(); ++worker) {
      const std::int32_t* copies = counts + (static_cast<std::ptrdiff_t>(worker) * bins + bin) * kHistogramCopies;
      for (int copy = 0; copy < kHistogramCopies; ++copy) total += copies[copy];
    }
    histogram[bin] = total;
  }
}

/// Widens the spans of the tiles that lanes touch, each lane in its own rectangle.
struct LaneTiles {
  float *nearest, *farthest;
  int stride;

  template <class F>
  PL_HD void widen(const kernels::Mask<F>& valid, const kernels::RayTiles<F>& at, const F& near, const F& far) {
    constexpr int kWidth = kernels::Lane<F>::width;
    alignas(64) float low[kWidth], high[kWidth];
    alignas(64) std::int32_t x0[kWidth], x1[kWidth], y0[kWidth], y1[kWidth];
    kernels::store(low, near);
    kernels::store(high, far);
    kernels::store_int(x0, at.x0);
    kernels::store_int(x1, at.x1);
    kernels::store_int(y0, at.y0);
    kernels::store_int(y1, kernels::select_int(valid, at.y1, kernels::Int<F>(-1)));
    for (int lane = 0; lane < kWidth; ++lane) {
      for (int y = y0[lane]; y <= y1[lane]; ++y) {
        for (int x = x0[lane]; x <= x1[lane]; ++x) {
          const int tile = y * stride + x;
          nearest[tile] = low[lane] < nearest[tile] ? low[lane] : nearest[tile];
          farthest[tile] = high[lane] > farthest[tile] ? high[lane] : farthest[tile];
        }
      }
    }
  }
};

/// Between which depths the rays of each tile can meet a surface. Each worker has tiles of its own; folding them is a
/// minimum and a maximum, which no order changes.
template <class F>
PL_HD void span_rays(const ThreadPool& threads, const kernels::RaySpans& kernel) {
  const int tiles = kernel.spans.stride * kernel.spans.rows, rows = kernel.volume.brick_rows();
  auto* scratch = static_cast<float*>(threads.scratch(
      0, 2 * sizeof(float) * static_cast<std::size_t>(tiles) * static_cast<std::size_t>(threads.count())));
  const auto nearest_of = [&](int worker) { return scratch + static_cast<std::ptrdiff_t>(worker) * 2 * tiles; };
  for (int worker = 0; worker < threads.count(); ++worker) {  // those of `farthest` are zero already
    for (int tile = 0; tile < tiles; ++tile) nearest_of(worker)[tile] = kernels::kNoRange;
  }
  constexpr int kRows = 64;
  threads.run((rows + kRows - 1) / kRows, [&](int chunk, int worker) {
    const kernels::RaySpans own = kernel;
    LaneTiles local{nearest_of(worker), nearest_of(worker) + tiles, kernel.spans.stride};
    const int end = (chunk + 1) * kRows < rows ? (chunk + 1) * kRows : rows;
    for (int row = chunk * kRows; row < end; ++row) {
      for (int x = 0; x < own.volume.bricks_per_row(); x += kernels::Lane<F>::width)
        own.template operator()<F>(x, row, local);
    }
  });
  for (int tile = 0; tile < tiles; ++tile) {
    float nearest = kernels::kNoRange, farthest = 0;
    for (int worker = 0; worker < threads.count(); ++worker) {
      const float *low = nearest_of(worker) + tile, *high = low + tiles;
      nearest = *low < nearest ? *low : nearest;
      farthest = *high > farthest ? *high : farthest;
    }
    kernel.spans.nearest[tile] = nearest;
    kernel.spans.farthest[tile] = farthest;
  }
}

/// Bricks that one task takes.
constexpr int kBricksPerChunk = 16;

/// Updates the listed bricks, first making sure that those without a surface get one.
template <class F, class Kernel>
PL_HD void for_each_brick(const ThreadPool& threads, const Kernel& kernel, const std::int32_t* list, int count) {
  constexpr int kWidth = kernels::Lane<F>::width;
  threads.run((count + kBricksPerChunk - 1) / kBricksPerChunk, [&](int chunk, int) {
    const Kernel own = kernel;
    const int end = (chunk + 1) * kBricksPerChunk < count ? (chunk + 1) * kBricksPerChunk : count;
    for (int i = chunk * kBricksPerChunk; i < end; ++i) {
      const int brick = list[i];
      const auto at = own.at(brick);
      bool occupied = own.volume.state(brick) != 0;
      for (int offset = 0; !occupied && offset < kernels::kBrickVoxels; offset += kWidth)
        occupied = kernels::any(own.template is_near_surface<F>(at, offset));
      if (!occupied) continue;
      auto behind = own.template update<F>(at, 0);
      for (int offset = kWidth; offset < kernels::kBrickVoxels; offset += kWidth) {
        const auto more = own.template update<F>(at, offset);  // not in the next line: || may leave it out
        behind = behind || more;
      }
      own.volume.state(brick) = kernels::any(behind) ? kernels::kBrickSolid : kernels::kBrickFree;
    }
  });
}

}  // namespace plumbline::cpu
