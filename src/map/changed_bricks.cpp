#include "map/changed_bricks.h"

#include <algorithm>

namespace plumbline {
namespace {

constexpr std::uint16_t kMaxInterval = 48;  ///< updates: a second and a half, so that what moves away does not stay

}  // namespace

ChangedBricks::ChangedBricks(const std::vector<BrickKey>& all) {
  note(all);
  note(all);
}

void ChangedBricks::note(const std::vector<BrickKey>& updated) {
  for (const BrickKey brick : updated) add(brick);
}

void ChangedBricks::add(BrickKey key) {
  Brick& brick = bricks_[key];
  if (brick.waits || ++brick.since < brick.due) return;
  brick.waits = true;
  (brick.taken ? again_ : fresh_).push_back(key);
}

std::vector<BrickKey> ChangedBricks::take(int count) {
  std::vector<BrickKey> taken;
  while (static_cast<int>(taken.size()) < count && waiting() > 0) {
    std::deque<BrickKey>& queue = fresh_.empty() ? again_ : fresh_;
    Brick& brick = bricks_[queue.front()];
    brick.due = std::min<std::uint16_t>(static_cast<std::uint16_t>(2 * brick.due), kMaxInterval);
    brick.since = 0;
    brick.waits = false;
    brick.taken = true;
    taken.push_back(queue.front());
    queue.pop_front();
  }
  return taken;
}

}  // namespace plumbline
