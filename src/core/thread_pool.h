// Threads with scratch memory. Nothing here is compiled per instruction set: the objects of the CPU's lanes reach
// oneTBB and the C++ library only through these functions, so that no inline function of theirs is emitted twice.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "plumbline/macros.h"

namespace plumbline {

/// A fixed number of threads, private to its owner.
class ThreadPool {
 public:
  /// 0 takes all of the machine's.
  explicit ThreadPool(int count);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int count() const { return count_; }

  /// Calls body(chunk, worker) for each chunk in [0, chunks), in any order; worker is in [0, count()).
  template <class Body>
  PL_HD void run(int chunks, const Body& body) const {
    run_erased(chunks, &body, &call<Body>);
  }

  /// Zeroed scratch memory, valid until the next call with the same slot (0 or 1); grows, never shrinks.
  void* scratch(int slot, std::size_t bytes) const;

 private:
  using Call = void (*)(const void* body, int chunk, int worker);
  template <class Body>
  static void call(const void* body, int chunk, int worker) {
    (*static_cast<const Body*>(body))(chunk, worker);
  }
  void run_erased(int chunks, const void* body, Call function) const;

  struct State;
  int count_;
  std::unique_ptr<State> state_;
};

}  // namespace plumbline
