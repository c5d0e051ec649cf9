#include "plumbline/time.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace plumbline {
namespace {

TEST(Time, ParsesStampsWithoutRounding) {
  EXPECT_EQ(parse_seconds("1305031102.160407"), 1'305'031'102'160'407'000);
  EXPECT_EQ(parse_seconds("1305031102.160407123"), 1'305'031'102'160'407'123);
  EXPECT_EQ(parse_seconds("12"), 12'000'000'000);
  EXPECT_EQ(parse_seconds("12."), 12'000'000'000);
  EXPECT_EQ(parse_seconds(".5"), 500'000'000);
  EXPECT_EQ(parse_seconds("-0.5"), -500'000'000);
  EXPECT_EQ(parse_seconds("+1.25"), 1'250'000'000);
  EXPECT_EQ(parse_seconds("1.3e9"), 1'300'000'000'000'000'000);
}

TEST(Time, RoundsDigitsPastTheNinth) {
  EXPECT_EQ(parse_seconds("0.1234567894"), 123'456'789);
  EXPECT_EQ(parse_seconds("0.1234567895"), 123'456'790);
  EXPECT_EQ(parse_seconds("0.9999999999"), 1'000'000'000);
}

TEST(Time, RefusesWhatIsNotAFiniteNumber) {
  for (const char* text : {"", ".", "-", "+", "abc", "1.2.3", "1,5", "--1", "+-1", "1-", "1.-5", "nan", "inf", "1e99",
                           "99999999999", "12 ", " 12", "0x10", "1e"})
    EXPECT_EQ(parse_seconds(text), std::nullopt) << '"' << text << '"';
}

TEST(Time, FormatsRoundedHalfAwayFromZero) {
  EXPECT_EQ(format_seconds(1'305'031'102'160'407'000), "1305031102.160407");
  EXPECT_EQ(format_seconds(1'500'000'000, 0), "2");
  EXPECT_EQ(format_seconds(-1'500'000'000, 0), "-2");
  EXPECT_EQ(format_seconds(-500'000'000), "-0.500000");
  EXPECT_EQ(format_seconds(-400, 6), "0.000000");
  EXPECT_EQ(format_seconds(7, 9), "0.000000007");
  EXPECT_EQ(format_seconds(std::numeric_limits<Nanoseconds>::min(), 9), "-9223372036.854775808");
}

TEST(Time, NineDecimalsReadBackExactly) {
  std::mt19937_64 random(1);
  std::uniform_int_distribution<Nanoseconds> any(-9'000'000'000'000'000'000, 9'000'000'000'000'000'000);
  for (int i = 0; i < 1000; ++i) {
    const Nanoseconds t = any(random);
    EXPECT_EQ(parse_seconds(format_seconds(t, 9)), t);
  }
}

TEST(Time, SecondsRoundToTheNearestNanosecond) {
  EXPECT_EQ(from_seconds(1e-9), 1);
  EXPECT_EQ(from_seconds(-1.6e-9), -2);
  EXPECT_DOUBLE_EQ(to_seconds(1'500'000'000), 1.5);
}

}  // namespace
}  // namespace plumbline
