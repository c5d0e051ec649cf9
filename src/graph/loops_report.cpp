#include <algorithm>

#include "plumbline/loops.h"

namespace plumbline {

std::string_view to_string(LoopStatus status) {
  switch (status) {
    case LoopStatus::accepted:
      return "accepted";
    case LoopStatus::not_registered:
      return "not registered";
    case LoopStatus::too_weak:
      return "too weak";
    case LoopStatus::one_way:
      return "one way";
    case LoopStatus::seen_through:
      return "seen through";
    case LoopStatus::too_far:
      return "too far";
    case LoopStatus::contradicted:
      return "contradicted";
  }
  return "unknown";
}

int LoopClosure::accepted() const { return count(LoopStatus::accepted); }

int LoopClosure::count(LoopStatus status) const {
  return static_cast<int>(
      std::count_if(loops.begin(), loops.end(), [&](const LoopReport& loop) { return loop.status == status; }));
}

}  // namespace plumbline
