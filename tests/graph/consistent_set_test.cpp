// The largest set of measurements that agree.
#include "graph/consistent_set.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace plumbline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(ConsistentSet, IsTheLargerOfTwoCamps) {
  const std::vector<double> values = {1.0, 5.0, 1.1, 5.1, 0.9, 9.0};
  const auto near = [&](std::size_t a, std::size_t b) { return std::abs(values[a] - values[b]) < 0.5; };
  EXPECT_THAT(consistent_set(values.size(), near), ElementsAre(0, 2, 4));
}

TEST(ConsistentSet, NeedsEveryTwoToAgree) {
  // A chain: each agrees with its neighbours alone.
  const auto neighbours = [](std::size_t a, std::size_t b) { return a + 1 == b || b + 1 == a; };
  EXPECT_EQ(consistent_set(5, neighbours).size(), 2U);
  EXPECT_THAT(consistent_set(0, neighbours), IsEmpty());
  EXPECT_THAT(consistent_set(1, neighbours), ElementsAre(0));
}

}  // namespace
}  // namespace plumbline
