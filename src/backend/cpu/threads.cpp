#include "backend/cpu/threads.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <new>
#include <thread>
#include <vector>

#include "core/error.h"
#include "core/threads.h"

namespace plumbline::cpu {
namespace {

constexpr int kScanChunk = 16384;
constexpr int kColumnBlock = 64;

int chunks_of(int count, int size) { return (count + size - 1) / size; }

struct AlignedDelete {
  void operator()(std::byte* p) const { ::operator delete[](p, std::align_val_t{64}); }
};

}  // namespace

struct Threads::State {
  explicit State(int count) : arena(allowed_threads(count)) {}
  tbb::task_arena arena;
  struct Scratch {
    std::unique_ptr<std::byte[], AlignedDelete> memory;
    std::size_t bytes = 0;
  };
  std::array<Scratch, 2> scratch;
};

Threads::Threads(int count)
    : count_(count > 0 ? count : std::max(1, static_cast<int>(std::thread::hardware_concurrency()))),
      state_(std::make_unique<State>(count_)) {}
Threads::~Threads() = default;

void Threads::run_erased(int chunks, const void* body, Call function) const {
  if (count_ == 1 || chunks <= 1) {
    for (int chunk = 0; chunk < chunks; ++chunk) function(body, chunk, 0);
    return;
  }
  state_->arena.execute([&] {
    tbb::parallel_for(0, chunks,
                      [&](int chunk) { function(body, chunk, tbb::this_task_arena::current_thread_index()); });
  });
}

void* Threads::scratch(int slot, std::size_t bytes) const {
  State::Scratch& scratch = state_->scratch.at(static_cast<std::size_t>(slot));
  if (scratch.bytes < bytes) {
    scratch.memory.reset(static_cast<std::byte*>(::operator new[](bytes, std::align_val_t{64})));
    scratch.bytes = bytes;
  }
  std::memset(scratch.memory.get(), 0, bytes);
  return scratch.memory.get();
}

int compact(const Threads& threads, const std::int32_t* flags, int count, std::int32_t* list) {
  const int chunks = chunks_of(count, kScanChunk);
  std::vector<int> first(static_cast<std::size_t>(chunks) + 1, 0);
  threads.run(chunks, [&](int chunk, int) {
    const int end = std::min(count, (chunk + 1) * kScanChunk);
    int marked = 0;
    for (int i = chunk * kScanChunk; i < end; ++i) marked += flags[i] != 0;
    first[static_cast<std::size_t>(chunk) + 1] = marked;
  });
  for (int chunk = 0; chunk < chunks; ++chunk)
    first[static_cast<std::size_t>(chunk) + 1] += first[static_cast<std::size_t>(chunk)];
  threads.run(chunks, [&](int chunk, int) {
    const int end = std::min(count, (chunk + 1) * kScanChunk);
    std::int32_t* out = list + first[static_cast<std::size_t>(chunk)];
    for (int i = chunk * kScanChunk; i < end; ++i) {
      if (flags[i] != 0) *out++ = i;
    }
  });
  return first.back();
}

std::int64_t scan(const Threads& threads, std::int32_t* values, int count) {
  const int chunks = chunks_of(count, kScanChunk);
  std::vector<std::int64_t> first(static_cast<std::size_t>(chunks) + 1, 0);
  threads.run(chunks, [&](int chunk, int) {
    const int end = std::min(count, (chunk + 1) * kScanChunk);
    std::int64_t sum = 0;
    for (int i = chunk * kScanChunk; i < end; ++i) sum += values[i];
    first[static_cast<std::size_t>(chunk) + 1] = sum;
  });
  for (int chunk = 0; chunk < chunks; ++chunk)
    first[static_cast<std::size_t>(chunk) + 1] += first[static_cast<std::size_t>(chunk)];
  if (first.back() > std::numeric_limits<std::int32_t>::max())
    throw Error("the surface has more elements than 32 bits can count", "mesh", "lower volume.resolution");
  threads.run(chunks, [&](int chunk, int) {
    const int end = std::min(count, (chunk + 1) * kScanChunk);
    auto sum = static_cast<std::int32_t>(first[static_cast<std::size_t>(chunk)]);
    for (int i = chunk * kScanChunk; i < end; ++i) {
      const std::int32_t value = values[i];
      values[i] = sum;
      sum += value;
    }
  });
  return first.back();
}

void integral_image(const Threads& threads, std::int32_t* data, int width, int height, int stride) {
  // Unsigned arithmetic: sums may wrap, and differences of wrapped sums are exact.
  threads.run(height, [&](int y, int) {
    auto* row = reinterpret_cast<std::uint32_t*>(data) + static_cast<std::ptrdiff_t>(y) * stride;
    for (int x = 1; x < width; ++x) row[x] += row[x - 1];
  });
  threads.run(chunks_of(width, kColumnBlock), [&](int block, int) {
    const int x0 = block * kColumnBlock, x1 = std::min(width, x0 + kColumnBlock);
    for (int y = 1; y < height; ++y) {
      auto* row = reinterpret_cast<std::uint32_t*>(data) + static_cast<std::ptrdiff_t>(y) * stride;
      const std::uint32_t* above = row - stride;
      for (int x = x0; x < x1; ++x) row[x] += above[x];
    }
  });
}

}  // namespace plumbline::cpu
