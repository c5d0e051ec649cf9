// The error of a chip that fuses its own readings into an orientation (Giancola, Schneider, Wonka, Ghanem 2018, §5).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "plumbline/orientation.h"

namespace plumbline {

/// A smooth function of an angle with the period 2π.
struct PeriodicError {
  double constant = 0;               ///< radians
  std::vector<double> coefficients;  ///< of `periodic`, radians: sine and cosine of each harmonic

  int harmonics() const { return static_cast<int>(coefficients.size() / 2); }
  double at(double angle) const;
};

/// Error of a fused orientation that depends on the orientation alone: about each earth axis a smooth 2π-periodic
/// function of the angle about that axis, the same whenever the sensor comes back to an orientation.
class SystematicError {
 public:
  /// `amplitude`: largest magnitude about x, y (tilt) and z (heading), radians, that each function reaches. `harmonics`
  /// ≥ 1. Throws Error for values out of range.
  SystematicError(const Eigen::Vector3d& amplitude, int harmonics, std::uint64_t seed);
  /// The functions themselves, as a characterisation finds them.
  explicit SystematicError(std::array<PeriodicError, 3> axes) : axes_(std::move(axes)) {}

  /// The function of axis 0…2 at an angle, radians.
  double about(int axis, double angle) const;
  /// Rotation vector in earth axes. The angle about an axis is that of the twist (`twist_about`).
  Eigen::Vector3d at(const Eigen::Matrix3d& earth_from_body) const;

 private:
  std::array<PeriodicError, 3> axes_;
};

struct OrientationErrorModel {
  Eigen::Vector3d amplitude = Eigen::Vector3d::Zero();  ///< radians: tilt about x and y, heading about z
  int harmonics = 3;
  std::uint64_t seed = 1;
  /// In place of functions drawn from the seed: those of a real sensor. `amplitude` then only says how large they are.
  std::optional<std::array<PeriodicError, 3>> measured = {};
};

/// "ideal": none; "bno055": ±3° of tilt, ±10° of heading, as the paper measured. Throws Error for other names.
OrientationErrorModel error_model(std::string_view name);

/// The samples as a sensor with this systematic error would have reported them: exp(error) earth_from_body, in earth
/// axes. There is no random part, as the paper found none. Throws Error for a model out of range.
std::vector<OrientationSample> with_error(const OrientationErrorModel& model, std::vector<OrientationSample> samples);

}  // namespace plumbline
