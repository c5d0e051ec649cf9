// Threads and scratch memory of one CPU backend. Nothing here is compiled per instruction set: the lanes' objects
// reach oneTBB and the C++ library only through these functions, so that no inline function of theirs is emitted twice.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "core/macros.h"

namespace plumbline::cpu {

/// A fixed number of threads, private to one backend.
class Threads {
 public:
  /// 0 takes all of the machine's.
  explicit Threads(int count);
  ~Threads();
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;

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

/// See Backend::compact, Backend::scan and Backend::integral_image.
int compact(const Threads& threads, const std::int32_t* flags, int count, std::int32_t* list);
std::int64_t scan(const Threads& threads, std::int32_t* values, int count);
void integral_image(const Threads& threads, std::int32_t* data, int width, int height, int stride);

}  // namespace plumbline::cpu
