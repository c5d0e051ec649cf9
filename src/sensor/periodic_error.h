// An error that depends on the orientation alone: about each earth axis a smooth 2π-periodic function of the angle
// about that axis (Giancola, Schneider, Wonka, Ghanem 2018, §5). Templates, so that the simulation of such an error and
// its calibration by automatic differentiation are one formula.
#pragma once

#include <Eigen/Geometry>
#include <cmath>

namespace plumbline {

template <class T>
struct Twist {
  T angle;   ///< radians
  T weight;  ///< 1; fades to 0 where there is next to no twist to speak of (half a turn about an axis across)
};

/// The part of a rotation that turns about one of the axes 0…2: the twist of swing and twist.
template <class T>
Twist<T> twist_about(const Eigen::Quaternion<T>& q, int axis) {
  using std::atan2;
  constexpr double kFaint = 0.04;  ///< of the twist's quaternion, squared length
  const T along = q.vec()[axis], size = along * along + q.w() * q.w();
  if (size < 1e-12) return {T(0), T(0)};  // no angle, and no derivative of one
  const T angle = 2.0 * atan2(along, q.w());
  if (!(size < kFaint)) return {angle, T(1)};
  const T share = size / kFaint;
  return {angle, share * share * (3.0 - 2.0 * share)};
}

/// Σ c[2k−2] sin kα + c[2k−1] cos kα over the harmonics k = 1…n.
template <class T>
T periodic(const T* coefficients, int harmonics, const T& angle) {
  using std::cos;
  using std::sin;
  T sum(0);
  for (int k = 1; k <= harmonics; ++k)
    sum += coefficients[2 * k - 2] * sin(double(k) * angle) + coefficients[2 * k - 1] * cos(double(k) * angle);
  return sum;
}

/// Rotation vector in earth axes, radians; `coefficients` are 2 n of x, then of y, then of z.
template <class T>
Eigen::Matrix<T, 3, 1> periodic_error(const T* coefficients, int harmonics,
                                      const Eigen::Quaternion<T>& earth_from_body) {
  Eigen::Matrix<T, 3, 1> error;
  for (int axis = 0; axis < 3; ++axis) {
    const Twist<T> twist = twist_about(earth_from_body, axis);
    error[axis] = twist.weight * periodic(coefficients + 2 * harmonics * axis, harmonics, twist.angle);
  }
  return error;
}

}  // namespace plumbline
