#include "plumbline/time.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <limits>

namespace plumbline {
namespace {

constexpr std::array<std::int64_t, 10> kPowersOfTen = {1,       10,        100,        1'000,       10'000,
                                                       100'000, 1'000'000, 10'000'000, 100'000'000, 1'000'000'000};
constexpr std::int64_t kMaxSeconds = std::numeric_limits<std::int64_t>::max() / kNanosecondsPerSecond - 1;

/// Takes the digits at the front of `text`; empty if their value is beyond any time.
std::optional<std::int64_t> take_integer(std::string_view* text) {
  std::int64_t value = 0;
  while (!text->empty() && text->front() >= '0' && text->front() <= '9') {
    value = 10 * value + (text->front() - '0');
    if (value > kMaxSeconds) return std::nullopt;
    text->remove_prefix(1);
  }
  return value;
}

/// Takes the digits after the point, as nanoseconds; those past the ninth round it.
std::int64_t take_fraction(std::string_view* text) {
  std::int64_t value = 0;
  std::size_t count = 0;
  for (; !text->empty() && text->front() >= '0' && text->front() <= '9'; ++count, text->remove_prefix(1)) {
    const int digit = text->front() - '0';
    if (count < 9) value = 10 * value + digit;
    if (count == 9 && digit >= 5) ++value;
  }
  return count < 9 ? value * kPowersOfTen[9 - count] : value;
}

std::optional<Nanoseconds> parse_scientific(std::string_view text) {
  double seconds = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seconds);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  if (!std::isfinite(seconds) || std::abs(seconds) > static_cast<double>(kMaxSeconds)) return std::nullopt;
  return from_seconds(seconds);
}

}  // namespace

std::optional<Nanoseconds> parse_seconds(std::string_view text) {
  std::string_view rest = text;
  const bool negative = rest.starts_with('-');
  if (negative || rest.starts_with('+')) rest.remove_prefix(1);
  if (rest.empty() || rest == ".") return std::nullopt;
  const auto seconds = take_integer(&rest);
  if (!seconds) return std::nullopt;
  std::int64_t fraction = 0;
  if (rest.starts_with('.')) {
    rest.remove_prefix(1);
    fraction = take_fraction(&rest);
  }
  if (!rest.empty()) return parse_scientific(text);
  const Nanoseconds t = *seconds * kNanosecondsPerSecond + fraction;
  return negative ? -t : t;
}

std::string format_seconds(Nanoseconds t, int decimals) {
  const bool negative = t < 0;
  std::uint64_t magnitude = negative ? ~static_cast<std::uint64_t>(t) + 1 : static_cast<std::uint64_t>(t);
  const auto unit = static_cast<std::uint64_t>(kPowersOfTen[static_cast<std::size_t>(9 - decimals)]);
  magnitude = (magnitude + unit / 2) / unit;
  const auto scale = static_cast<std::uint64_t>(kPowersOfTen[static_cast<std::size_t>(decimals)]);
  const std::string_view sign = negative && magnitude != 0 ? "-" : "";
  if (decimals == 0) return fmt::format("{}{}", sign, magnitude / scale);
  return fmt::format("{}{}.{:0{}}", sign, magnitude / scale, magnitude % scale, decimals);
}

}  // namespace plumbline
