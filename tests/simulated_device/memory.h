// Address ranges of the simulated device: its own memory, which the host cannot touch, pinned memory of the host and
// managed memory. Each word has a cell that remembers who touched it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

namespace plumbline::simulated {

/// An access as a cell remembers it (order.h); 0 is none.
using Stamp = std::uint64_t;

/// The previous write of a word, and two of the reads since then that are not in order with each other.
struct Cell {
  Stamp write = 0, reads[2] = {0, 0};
};

enum class Space { device, pinned, managed };

struct Allocation {
  std::uintptr_t begin = 0;
  std::size_t bytes = 0;
  Space space = Space::device;
  Stamp written = 0;  ///< of all words whose cells are empty
};

class Memory {
 public:
  static Memory& get() { return instance_; }

  /// Filled with a pattern that is no plausible value. Null where the range is used up.
  void* allocate(Space space, std::size_t bytes);
  /// Whether there was one.
  bool free(Space space, void* address);

  bool contains(std::uintptr_t address) const { return address - base_ < 3 * kSpaceBytes; }
  bool is_device(std::uintptr_t address) const { return address - base_ < kSpaceBytes; }
  /// Null outside of every allocation.
  Allocation* find(std::uintptr_t address) {
    if (previous_ != nullptr && address - previous_->begin < previous_->bytes) return previous_;
    return search(address);
  }
  /// Of a word in one of the arenas; empty outside of every allocation.
  Cell& cell(std::uintptr_t address) const { return cells_[(address - base_) / 4]; }
  /// All of an allocation is written by one operation: its cells are empty again.
  void forget(Allocation& allocation, Stamp written);

  /// The host's code runs between `close` and `open`: the device's memory is then out of reach.
  void open();
  void close();

 private:
  [[gnu::visibility("hidden")]] static Memory instance_;
  static constexpr std::size_t kSpaceBytes = std::size_t{1} << 36, kPage = 4096;
  Memory();
  /// Addresses from the beginning: nothing is allocated.
  void begin_anew();
  Allocation* search(std::uintptr_t address);

  std::uintptr_t base_ = 0, next_[3] = {};
  Cell* cells_ = nullptr;
  std::map<std::uintptr_t, Allocation> allocations_;
  Allocation* previous_ = nullptr;
  bool open_ = false;
};

/// "byte 12 of an allocation of 64 bytes in the device's memory".
std::string describe(std::uintptr_t address);

}  // namespace plumbline::simulated
