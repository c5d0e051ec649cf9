#include "plumbline/error.h"

#include <gtest/gtest.h>

namespace plumbline {
namespace {

TEST(Error, SaysWhereWhatAndWhatToDo) {
  const Error error("no such file", "depth.txt", "Check the path.");
  EXPECT_STREQ(error.what(), "depth.txt: no such file\n  Check the path.");
  EXPECT_EQ(error.where(), "depth.txt");
}

TEST(Error, WithoutAdviceIsOneLine) { EXPECT_STREQ(Error("no such file", "a.ply", "").what(), "a.ply: no such file"); }

}  // namespace
}  // namespace plumbline
