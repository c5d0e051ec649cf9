#include "io/imu/joined_sensors.h"

#include <algorithm>
#include <cstdlib>
#include <optional>

namespace plumbline {
namespace {

/// The force at a moment between two samples that are not far from each other.
std::optional<Eigen::Vector3d> force_at(const std::vector<ImuSample>& samples, Nanoseconds time) {
  constexpr Nanoseconds kMaxGap = kNanosecondsPerSecond / 5, kBeyond = kNanosecondsPerSecond / 50;
  const auto after = std::lower_bound(samples.begin(), samples.end(), time,
                                      [](const ImuSample& sample, Nanoseconds t) { return sample.time < t; });
  if (after == samples.end() || (after == samples.begin() && after->time > time)) {
    const ImuSample& end = after == samples.end() ? samples.back() : samples.front();
    if (std::abs(end.time - time) > kBeyond) return std::nullopt;
    return end.specific_force;
  }
  if (after->time == time) return after->specific_force;
  const ImuSample &a = *(after - 1), &b = *after;
  if (b.time - a.time > kMaxGap) return std::nullopt;
  return interpolated(a, b, time).specific_force;
}

}  // namespace

std::vector<ImuSample> join_sensors(const std::vector<ImuSample>& rates, const std::vector<ImuSample>& forces) {
  std::vector<ImuSample> joined;
  if (forces.empty()) return joined;
  for (const ImuSample& rate : rates) {
    const auto force = force_at(forces, rate.time);
    if (!force) continue;
    joined.push_back(rate);
    joined.back().specific_force = *force;
  }
  return joined;
}

}  // namespace plumbline
