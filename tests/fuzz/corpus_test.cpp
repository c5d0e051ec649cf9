// The corpus once through every parser, with what the fuzzers found before; needs no libFuzzer.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "fuzz/targets.h"
#include "support/source.h"

namespace plumbline::fuzz {
namespace {

namespace fs = std::filesystem;

class Corpus : public testing::TestWithParam<std::string> {};

TEST_P(Corpus, IsParsedOrRefused) {
  int files = 0;
  for (const auto& entry : fs::directory_iterator(test::source_root() / "tests/fuzz/corpus" / GetParam())) {
    SCOPED_TRACE(entry.path().filename().string());
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    EXPECT_TRUE(run_target(GetParam(), bytes));
    EXPECT_TRUE(run_target(GetParam(), std::string_view(bytes).substr(0, bytes.size() / 2)));
    ++files;
  }
  EXPECT_GT(files, 0);
}

INSTANTIATE_TEST_SUITE_P(Fuzz, Corpus, testing::ValuesIn(target_names()),
                         [](const auto& target) { return target.param; });

}  // namespace
}  // namespace plumbline::fuzz
