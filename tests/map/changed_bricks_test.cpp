// Which bricks a copy of the map is given, and when.
#include "map/changed_bricks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace plumbline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(ChangedBricks, AllThatIsThereIsDue) {
  ChangedBricks changes({3, 5, 9});
  EXPECT_EQ(changes.waiting(), 3);
  EXPECT_THAT(changes.take(2), ElementsAre(3, 5));
  EXPECT_THAT(changes.take(2), ElementsAre(9));
  EXPECT_THAT(changes.take(2), IsEmpty());
}

TEST(ChangedBricks, ASteadyViewCostsEverLess) {
  ChangedBricks changes({});
  int taken = 0, second_half = 0;
  for (int frame = 0; frame < 200; ++frame) {
    changes.note({7});
    const auto count = static_cast<int>(changes.take(10).size());
    taken += count;
    if (frame >= 100) second_half += count;
  }
  EXPECT_GE(taken, 7);
  EXPECT_LE(taken, 10);
  EXPECT_GE(second_half, 2) << "what moves away would stay";
}

TEST(ChangedBricks, WhatIsNewComesFirst) {
  ChangedBricks changes({1, 2});
  changes.take(2);
  for (int i = 0; i < 8; ++i) changes.note({1, 2});
  changes.note({4});
  EXPECT_EQ(changes.waiting(), 2) << "one update alone is noise";
  changes.note({4});
  EXPECT_THAT(changes.take(10), ElementsAre(4, 1, 2));
}

}  // namespace
}  // namespace plumbline
