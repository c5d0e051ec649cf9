// What happened before what. The host and every stream are actors; each operation of a stream is an interval of its
// actor, and knows (a vector clock) which intervals of the others are over. Within a kernel, barriers cut the intervals
// into segments, each of one block: two accesses are in order if a barrier that both passed lies between them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "simulated_device/memory.h"

namespace plumbline::simulated {

constexpr int kWarp = 32;

/// Intervals of each actor that are over.
using Clock = std::vector<std::uint32_t>;
void join(Clock* clock, const Clock& other);

class Order {
 public:
  static constexpr int kHost = 0;

  static Order& get() { return instance_; }

  int add_actor();
  /// An interval of `actor` begins, after all intervals that `clock` counts and the actor's earlier ones.
  void begin(int actor, const Clock& clock);
  /// From here on the host does something; an interval begins with its first access.
  void host_goes_on() { is_host_ = true, host_has_interval_ = false; }
  std::uint32_t host_intervals() const { return static_cast<std::uint32_t>(first_of_[kHost].size()); }
  Clock& host_clock() { return host_clock_; }
  /// Before an access of the host.
  void host_accesses() {
    if (!host_has_interval_) begin(kHost, host_clock_);
    host_has_interval_ = is_host_ = true;
  }
  bool is_host() const { return is_host_; }

  // Within a kernel.
  /// A segment of a block, after its earlier ones.
  std::uint32_t new_segment(int block);
  /// All blocks are past the grid's barrier; each takes a new segment.
  void grid_barrier();
  /// Who runs.
  void run(std::uint32_t segment, int block, int thread, int warp_phase) {
    segment_ = segment, block_ = block, thread_ = thread;
    stamp_ = Stamp{segment} << 28 | static_cast<Stamp>(thread) << 17 | static_cast<Stamp>(warp_phase & 0xfff) << 5;
  }

  /// Of an access of some bytes (a bit each) of a word, now.
  Stamp stamp(unsigned bytes, bool is_atomic) const { return stamp_ | Stamp{is_atomic} << 4 | bytes; }
  /// Whether an earlier access is in order with what happens now.
  bool is_before(Stamp earlier) const {
    const auto segment = static_cast<std::uint32_t>(earlier >> 28);
    if (segment < first_segment_)
      return segment < first_unordered_ || segment >= interval_begin_ || is_interval_before(segment);
    if (block_of_[segment - first_segment_] != block_) return false;
    if (segment != segment_) return true;
    const auto thread = static_cast<int>(earlier >> 17 & 0x7ff);
    return thread == thread_ || (thread / kWarp == thread_ / kWarp && ((earlier ^ stamp_) >> 5 & 0xfff) != 0);
  }

 private:
  struct Interval {
    std::uint32_t first_segment, index;
    int actor;
  };
  [[gnu::visibility("hidden")]] static Order instance_;
  Order() { add_actor(); }
  bool is_interval_before(std::uint32_t segment) const;

  std::vector<Interval> intervals_;
  std::vector<std::vector<std::uint32_t>> first_of_;  ///< segments that an actor's intervals begin with
  Clock host_clock_, clock_;
  int actor_ = kHost;
  bool is_host_ = true, host_has_interval_ = false;
  std::uint32_t next_segment_ = 1, first_segment_ = 1, first_unordered_ = 1, interval_begin_ = 1, segment_ = 0;
  std::vector<int> block_of_;
  int block_ = 0, thread_ = 0;
  Stamp stamp_ = 0;
};

}  // namespace plumbline::simulated
