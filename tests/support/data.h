// Where the real sequences are; tests that need them skip with a message where they are missing.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>

namespace plumbline::test {

/// $PLUMBLINE_DATA, or ../shared/data beside the checkout.
std::filesystem::path data_root();

/// A folder or file of the data set, or a skipped test.
#define PLUMBLINE_DATA_OR_SKIP(variable, relative)                                  \
  const std::filesystem::path variable = plumbline::test::data_root() / (relative); \
  if (!std::filesystem::exists(variable))                                           \
  GTEST_SKIP() << "no test data at " << variable << "; set PLUMBLINE_DATA to the folder that has it"

}  // namespace plumbline::test
