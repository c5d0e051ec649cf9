// The one clock of a recording.
//
// Everything is stamped with the system's monotonic clock, which neither a user nor the network sets. Files have
// seconds since 1970: the distance of the two clocks is taken once, when a recording begins.
#pragma once

#include <optional>

#include "plumbline/time.h"

namespace plumbline::capture {

/// Nanoseconds of the monotonic clock.
Nanoseconds now();

/// What has to be added to now() for nanoseconds since 1970, at this moment.
Nanoseconds unix_offset();

/// Brings the stamps of a device's own clock to ours. What arrives is late by an unknown delay that varies and is never
/// negative, so the smallest difference of arrival and stamp tells the offset; it may grow slowly, as quartzes drift.
class DeviceClock {
 public:
  /// Time of a reading that the device stamped `device` and that arrived at `arrival`; never after `arrival`, and later
  /// than the one before. A device clock that jumps is followed: at once where it steps back or ahead of what arrival
  /// allows, after a few readings where it only seems late.
  Nanoseconds to_host(Nanoseconds device, Nanoseconds arrival);

  /// What has to be added to a stamp near the previous one for its time.
  Nanoseconds shift() const { return previous_ ? previous_->host - previous_->device : 0; }

  /// How often the device's clock was seen to jump.
  int jumps() const { return jumps_; }

 private:
  void restart(Nanoseconds device, Nanoseconds arrival);

  struct Reading {
    Nanoseconds device, arrival, host;
  };
  std::optional<Reading> previous_;
  Nanoseconds offset_ = 0;
  int late_ = 0;  // readings in a row that were later than delays are
  int jumps_ = 0;
};

}  // namespace plumbline::capture
