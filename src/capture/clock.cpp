#include "capture/clock.h"

#include <algorithm>
#include <ctime>

namespace plumbline::capture {
namespace {

constexpr Nanoseconds kMaxDelay = kNanosecondsPerSecond / 5;
constexpr int kLateReadings = 5;       // in a row are no delay but another clock
constexpr Nanoseconds kDrift = 10000;  // one part in so many: a poor quartz is off by 100 in a million

Nanoseconds read_clock(clockid_t id) {
  timespec t{};
  clock_gettime(id, &t);
  return t.tv_sec * kNanosecondsPerSecond + t.tv_nsec;
}

}  // namespace

Nanoseconds now() { return read_clock(CLOCK_MONOTONIC); }

Nanoseconds unix_offset() { return read_clock(CLOCK_REALTIME) - now(); }

void DeviceClock::restart(Nanoseconds device, Nanoseconds arrival) {
  if (previous_) ++jumps_;
  offset_ = arrival - device;
  late_ = 0;
}

Nanoseconds DeviceClock::to_host(Nanoseconds device, Nanoseconds arrival) {
  const Nanoseconds difference = arrival - device;
  if (!previous_ || device <= previous_->device || difference < offset_ - kMaxDelay) {
    restart(device, arrival);
  } else if (difference > offset_ + kMaxDelay) {
    if (++late_ >= kLateReadings) restart(device, arrival);
  } else {
    late_ = 0;
    offset_ = std::min(difference, offset_ + (arrival - previous_->arrival) / kDrift);
  }
  Nanoseconds host = std::min(device + offset_, arrival);
  if (previous_) host = std::max(host, previous_->host + 1);
  previous_ = {device, arrival, host};
  return host;
}

}  // namespace plumbline::capture
