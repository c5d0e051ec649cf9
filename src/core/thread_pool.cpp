#include "core/thread_pool.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <new>
#include <thread>

#include "core/threads.h"

namespace plumbline {
namespace {

struct AlignedDelete {
  void operator()(std::byte* p) const { ::operator delete[](p, std::align_val_t{64}); }
};

}  // namespace

struct ThreadPool::State {
  explicit State(int count) : arena(allowed_threads(count)) {}
  tbb::task_arena arena;
  struct Scratch {
    std::unique_ptr<std::byte[], AlignedDelete> memory;
    std::size_t bytes = 0;
  };
  std::array<Scratch, 2> scratch;
};

ThreadPool::ThreadPool(int count)
    : count_(count > 0 ? count : std::max(1, static_cast<int>(std::thread::hardware_concurrency()))),
      state_(std::make_unique<State>(count_)) {}
ThreadPool::~ThreadPool() = default;

void ThreadPool::run_erased(int chunks, const void* body, Call function) const {
  if (count_ == 1 || chunks <= 1) {
    for (int chunk = 0; chunk < chunks; ++chunk) function(body, chunk, 0);
    return;
  }
  state_->arena.execute([&] {
    tbb::parallel_for(0, chunks,
                      [&](int chunk) { function(body, chunk, tbb::this_task_arena::current_thread_index()); });
  });
}

void* ThreadPool::scratch(int slot, std::size_t bytes) const {
  State::Scratch& scratch = state_->scratch.at(static_cast<std::size_t>(slot));
  if (scratch.bytes < bytes) {
    scratch.memory.reset(static_cast<std::byte*>(::operator new[](bytes, std::align_val_t{64})));
    scratch.bytes = bytes;
  }
  std::fill_n(scratch.memory.get(), bytes, std::byte{0});
  return scratch.memory.get();
}

}  // namespace plumbline
