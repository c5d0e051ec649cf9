// Time is integer nanoseconds; text in seconds is converted digit by digit, so no stamp is rounded.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "plumbline/export.h"

namespace plumbline {

using Nanoseconds = std::int64_t;
constexpr Nanoseconds kNanosecondsPerSecond = 1'000'000'000;

inline double to_seconds(Nanoseconds t) { return static_cast<double>(t) * 1e-9; }
inline Nanoseconds from_seconds(double s) { return static_cast<Nanoseconds>(s * 1e9 + (s < 0 ? -0.5 : 0.5)); }

/// Decimal seconds ("1305031102.160407", "-0.5", "12", "1.3e9") to nanoseconds; digits past the ninth decimal are
/// rounded. Empty when the text is not a finite number or leaves the range of 64-bit nanoseconds (about 292 years).
PLUMBLINE_EXPORT std::optional<Nanoseconds> parse_seconds(std::string_view text);

/// Nanoseconds as decimal seconds with `decimals` (0…9) digits, rounded half away from zero.
PLUMBLINE_EXPORT std::string format_seconds(Nanoseconds t, int decimals = 6);

}  // namespace plumbline
