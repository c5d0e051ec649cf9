#include "tracking/interruption.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/median.h"

namespace plumbline {
namespace {

constexpr std::size_t kRemembered = 61;
constexpr double kUnusual = 2.5;  // times the usual interval

}  // namespace

void FrameIntervals::observe(Nanoseconds time) {
  if (previous_) seconds_.push_back(std::abs(to_seconds(time - *previous_)));
  if (seconds_.size() > kRemembered) seconds_.pop_front();
  previous_ = time;
}

bool FrameIntervals::is_interrupted(Nanoseconds previous, Nanoseconds time, double max_gap) const {
  const double usual = median(std::vector<double>(seconds_.begin(), seconds_.end()));
  return std::abs(to_seconds(time - previous)) > std::max(max_gap, kUnusual * usual);
}

}  // namespace plumbline
