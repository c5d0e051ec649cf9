// Words that the messages and the files of calibration share.
#pragma once

#include <fmt/format.h>

#include <cstddef>
#include <string>
#include <string_view>

#include "plumbline/angles.h"
#include "plumbline/orientation.h"

namespace plumbline {

/// Name of one value of a convention (QuaternionOrder, OrientationOf, EarthAxes).
template <class E>
std::string_view name_of(E value) {
  return names(E{})[static_cast<std::size_t>(value)];
}

inline std::string degrees_text(double radians) { return fmt::format("{:.1f}°", degrees(radians)); }

}  // namespace plumbline
