#include "tracking/interruption.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/median.h"

namespace plumbline {
namespace {

constexpr std::size_t kRemembered = 61;
// Times the usual interval. A camera that left frames out was watched all the same; frames that were lost were not.
constexpr double kUnusual = 2.5, kUnusualAfterLoss = 1.5;

}  // namespace

void FrameIntervals::observe(Nanoseconds time) {
  if (previous_) seconds_.push_back(std::abs(to_seconds(time - *previous_)));
  if (seconds_.size() > kRemembered) seconds_.pop_front();
  previous_ = time;
}

bool FrameIntervals::is_interrupted(Nanoseconds previous, Nanoseconds time, double max_gap) const {
  const double usual = median(std::vector<double>(seconds_.begin(), seconds_.end()));
  const double gap = std::abs(to_seconds(time - previous));
  const bool has_lost = !seconds_.empty() && gap > 1.1 * seconds_.back();  // the frame before this one was not accepted
  return gap > std::max(max_gap, (has_lost ? kUnusualAfterLoss : kUnusual) * usual);
}

}  // namespace plumbline
