#include "plumbline/prefetch.h"

#include <algorithm>
#include <chrono>

#include "plumbline/error.h"

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

std::optional<Frame> ReadableFrames::next() {
  constexpr std::size_t kPatience = 20;
  const auto most_are_bad = [&] { return skipped_.size() > good_; };
  while (!most_are_bad() || skipped_.size() <= kPatience) {
    std::optional<Frame> frame;
    try {
      frame = frames_.next();
    } catch (const Error& error) {
      if (!first_failure_) first_failure_ = std::current_exception();
      skipped_.emplace_back(error.what());
      continue;
    }
    if (frame) ++good_;
    if (frame || !most_are_bad()) return frame;
    break;
  }
  std::rethrow_exception(first_failure_);
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
