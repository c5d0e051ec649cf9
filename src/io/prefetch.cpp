#include "io/prefetch.h"

#include <algorithm>
#include <chrono>

namespace plumbline {
namespace {

using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

}  // namespace

Prefetcher::Prefetcher(const Sequence& sequence, std::vector<int> indices, int ahead)
    : sequence_(sequence), indices_(std::move(indices)), ahead_(static_cast<std::size_t>(std::max(ahead, 1))) {
  thread_ = std::thread([this] { decode_all(); });
}

Prefetcher::~Prefetcher() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

std::optional<Frame> Prefetcher::next() {
  if (handed_out_ == indices_.size()) return std::nullopt;
  const Clock::time_point start = Clock::now();
  Item item;
  {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !ready_.empty(); });
    item = std::move(ready_.front());
    ready_.pop_front();
  }
  changed_.notify_all();
  ++handed_out_;
  wait_milliseconds_ = milliseconds_since(start);
  decode_milliseconds_ = item.milliseconds;
  if (item.error) std::rethrow_exception(item.error);
  return std::move(item.frame);
}

Prefetcher::Item Prefetcher::decode(int index) const {
  const Clock::time_point start = Clock::now();
  Item item;
  try {
    item.frame = sequence_.read(index);
  } catch (...) {
    item.error = std::current_exception();
  }
  item.milliseconds = milliseconds_since(start);
  return item;
}

void Prefetcher::decode_all() {
  for (const int index : indices_) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return stopping_ || ready_.size() < ahead_; });
      if (stopping_) return;
    }
    Item item = decode(index);
    {
      const std::lock_guard lock(mutex_);
      ready_.push_back(std::move(item));
    }
    changed_.notify_all();
  }
}

}  // namespace plumbline
