// Angles are radians everywhere; degrees stand in files, options and what is shown to people.
#pragma once

#include <numbers>

namespace plumbline {

/// Factors for vectors and matrices of angles.
constexpr double kRadiansPerDegree = std::numbers::pi / 180, kDegreesPerRadian = 180 / std::numbers::pi;

constexpr double radians(double degrees) { return degrees * kRadiansPerDegree; }
constexpr double degrees(double radians) { return radians * kDegreesPerRadian; }

}  // namespace plumbline
