// Which bricks a copy of the map that is kept elsewhere lacks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <unordered_map>
#include <vector>

#include "map/packed_bricks.h"

namespace plumbline {

/// A running average over n frames moves by about 1/n with the next one, so a brick is due after as many more updates
/// as it had when it was taken, within limits: a steady view costs ever less, and what is new comes first.
class ChangedBricks {
 public:
  /// `all`: the bricks that there are; all are due.
  explicit ChangedBricks(const std::vector<BrickKey>& all);

  /// Bricks that one frame updated.
  void note(const std::vector<BrickKey>& updated);
  /// At most `count` of those that are due.
  std::vector<BrickKey> take(int count);
  int waiting() const { return static_cast<int>(fresh_.size() + again_.size()); }

 private:
  struct Brick {
    std::uint16_t since = 0;  ///< updates since it was taken
    std::uint16_t due = 2;    ///< updates after which it is due; one alone is mostly noise
    bool waits = false;
    bool taken = false;
  };
  void add(BrickKey key);

  std::unordered_map<BrickKey, Brick> bricks_;
  std::deque<BrickKey> fresh_, again_;
};

}  // namespace plumbline
