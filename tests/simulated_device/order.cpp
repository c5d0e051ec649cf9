#include "simulated_device/order.h"

#include <algorithm>
#include <iterator>

namespace plumbline::simulated {

void join(Clock* clock, const Clock& other) {
  clock->resize(std::max(clock->size(), other.size()));
  for (std::size_t i = 0; i < other.size(); ++i) (*clock)[i] = std::max((*clock)[i], other[i]);
}

Order Order::instance_;

int Order::add_actor() {
  first_of_.emplace_back();
  return static_cast<int>(first_of_.size()) - 1;
}

void Order::begin(int actor, const Clock& clock) {
  actor_ = actor;
  is_host_ = actor == kHost;
  host_has_interval_ = false;
  clock_ = clock;
  clock_.resize(first_of_.size());
  first_segment_ = first_unordered_ = interval_begin_ = next_segment_;
  for (std::size_t other = 0; other < first_of_.size(); ++other) {
    const std::vector<std::uint32_t>& first = first_of_[other];
    if (static_cast<int>(other) != actor && first.size() > clock_[other])
      first_unordered_ = std::min(first_unordered_, first[clock_[other]]);
  }
  std::vector<std::uint32_t>& own = first_of_[static_cast<std::size_t>(actor)];
  intervals_.push_back({next_segment_, static_cast<std::uint32_t>(own.size()), actor});
  own.push_back(next_segment_);
  block_of_.clear();
  run(new_segment(0), 0, 0, 0);
}

std::uint32_t Order::new_segment(int block) {
  block_of_.push_back(block);
  return next_segment_++;
}

void Order::grid_barrier() {
  first_segment_ = next_segment_;
  block_of_.clear();
}

bool Order::is_interval_before(std::uint32_t segment) const {
  const auto next = std::upper_bound(intervals_.begin(), intervals_.end(), segment,
                                     [](std::uint32_t s, const Interval& i) { return s < i.first_segment; });
  const Interval& interval = *std::prev(next);
  return interval.actor == actor_ || interval.index < clock_[static_cast<std::size_t>(interval.actor)];
}

}  // namespace plumbline::simulated
