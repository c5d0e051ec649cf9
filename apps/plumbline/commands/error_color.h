// Distances as colours, for meshes painted by their error.
#pragma once

#include <algorithm>

#include "plumbline/mesh.h"

namespace plumbline::app {

/// Green for none, over yellow at half the range to red at its end and beyond. Both in metres.
inline Mesh::Rgb error_color(double error, double range) {
  const double share = std::clamp(error / range, 0.0, 1.0);
  const double red = std::min(1.0, 2 * share), green = std::min(1.0, 2 - 2 * share);
  return {static_cast<std::uint8_t>(40 + 200 * red), static_cast<std::uint8_t>(40 + 160 * green), 50};
}

}  // namespace plumbline::app
