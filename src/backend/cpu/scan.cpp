#include "backend/cpu/scan.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "plumbline/error.h"

namespace plumbline::cpu {
namespace {

constexpr int kScanChunk = 16384;

int chunks_of(int count, int size) { return (count + size - 1) / size; }

}  // namespace

int compact(const ThreadPool& threads, const std::int32_t* flags, int count, std::int32_t* list) {
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

std::int64_t scan(const ThreadPool& threads, std::int32_t* values, int count) {
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

}  // namespace plumbline::cpu
