#include "core/time.h"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>

namespace plumbline {
namespace {

constexpr std::array<std::int64_t, 10> kPowersOfTen = {1,       10,        100,        1'000,       10'000,
                                                       100'000, 1'000'000, 10'000'000, 100'000'000, 1'000'000'000};
constexpr std::int64_t kMaxSeconds = std::numeric_limits<std::int64_t>::max() / kNanosecondsPerSecond - 1;

std::optional<std::int64_t> parse_integer(std::string_view digits) {
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
  return value;
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
  if (text.empty()) return std::nullopt;
  if (text.find_first_not_of("+-0123456789.") != std::string_view::npos) return parse_scientific(text);
  const bool negative = text.front() == '-';
  if (negative || text.front() == '+') text.remove_prefix(1);
  const std::size_t point = text.find('.');
  const std::string_view whole = text.substr(0, point);
  const std::string_view decimals = point == std::string_view::npos ? "" : text.substr(point + 1);
  if (whole.empty() && decimals.empty()) return std::nullopt;
  if (whole.find_first_of("+-") != std::string_view::npos) return std::nullopt;

  const auto seconds = whole.empty() ? std::optional<std::int64_t>(0) : parse_integer(whole);
  if (!seconds || *seconds > kMaxSeconds) return std::nullopt;
  std::int64_t fraction = 0;
  if (!decimals.empty()) {
    if (decimals.find_first_not_of("0123456789") != std::string_view::npos) return std::nullopt;
    const std::string_view kept = decimals.substr(0, 9);
    fraction = *parse_integer(kept) * kPowersOfTen[9 - kept.size()];
    if (decimals.size() > 9 && decimals[9] >= '5') ++fraction;
  }
  const Nanoseconds t = *seconds * kNanosecondsPerSecond + fraction;
  return negative ? -t : t;
}

std::string format_seconds(Nanoseconds t, int decimals) {
  const bool negative = t < 0;
  std::uint64_t magnitude = negative ? ~static_cast<std::uint64_t>(t) + 1 : static_cast<std::uint64_t>(t);
  const auto unit = static_cast<std::uint64_t>(kPowersOfTen[static_cast<std::size_t>(9 - decimals)]);
  magnitude = (magnitude + unit / 2) / unit;
  const auto scale = static_cast<std::uint64_t>(kPowersOfTen[static_cast<std::size_t>(decimals)]);
  std::string text = (negative && magnitude != 0 ? "-" : "") + std::to_string(magnitude / scale);
  if (decimals == 0) return text;
  std::string fraction = std::to_string(magnitude % scale);
  return text + "." + std::string(static_cast<std::size_t>(decimals) - fraction.size(), '0') + fraction;
}

}  // namespace plumbline
