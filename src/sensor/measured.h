#pragma once

#include <optional>

#include <Eigen/Core>

namespace plumbline {

/// Whether a reading of an accelerometer or magnetometer is there: finite, and not the zero of a sensor that is off.
inline bool is_measured(const Eigen::Vector3d& v) { return v.allFinite() && v.squaredNorm() > 0; }
inline bool is_measured(const std::optional<Eigen::Vector3d>& v) { return v && is_measured(*v); }

}  // namespace plumbline
