// Orientations: a sensor's reading, how a file writes one, and what it means in our axes.
//
// Frames: E earth (x east, y north, z up), A the earth axes of the file, B the sensor's body.
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "plumbline/orientation.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"

namespace plumbline {

/// A reading of an orientation sensor: E earth (x east, y north, z up), B the sensor's body.
struct OrientationSample {
  Nanoseconds time = 0;
  Eigen::Matrix3d earth_from_body = Eigen::Matrix3d::Identity();
};

enum class QuaternionOrder { xyzw, wxyz };
constexpr auto names(QuaternionOrder) { return std::array<std::string_view, 2>{"xyzw", "wxyz"}; }

enum class OrientationOf { body_to_world, world_to_body };
constexpr auto names(OrientationOf) { return std::array<std::string_view, 2>{"body-to-world", "world-to-body"}; }

/// All right-handed: east north up, north east down, or (as in graphics) x east, y up, z south.
enum class EarthAxes { enu, ned, y_up };
constexpr auto names(EarthAxes) { return std::array<std::string_view, 3>{"enu", "ned", "y-up"}; }

struct OrientationConvention {
  std::optional<QuaternionOrder> quaternion = {};  ///< empty: by the file's format, xyzw where there is none
  OrientationOf orientation_of = OrientationOf::body_to_world;
  EarthAxes earth = EarthAxes::enu;
  bool has_heading = true;  ///< false: only the tilt is measured, and a turn about the vertical means nothing
  bool has_up = true;       ///< false: only turns are measured, by a gyroscope alone; the earth's axes mean nothing
};

/// What is known of an orientation sensor beside its readings.
struct OrientationSensor {
  bool has_heading = true;  ///< as in OrientationConvention
  /// Of its errors about the earth's axes (east, north, up), radians², positive definite. Empty: that of the sigmas in
  /// OrientationParameters.
  std::optional<Eigen::Matrix3d> covariance = {};
};

/// earth_from_axes.
inline Eigen::Matrix3d enu_from(EarthAxes axes) {
  Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
  if (axes == EarthAxes::ned) m << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  if (axes == EarthAxes::y_up) m << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  return m;
}

/// earth_from_body of the four numbers of a file, in the order in which they stand there. Their length need not be 1.
inline Eigen::Matrix3d decode_orientation(const Eigen::Vector4d& n, const OrientationConvention& convention) {
  const bool w_first = convention.quaternion == QuaternionOrder::wxyz;
  const Eigen::Quaterniond q = w_first ? Eigen::Quaterniond(n[0], n[1], n[2], n[3]) : Eigen::Quaterniond(n);
  const Eigen::Matrix3d rotation = q.normalized().toRotationMatrix();
  const bool inverse = convention.orientation_of == OrientationOf::world_to_body;
  return enu_from(convention.earth) * (inverse ? rotation.transpose() : rotation);
}

/// The four numbers that a file of this convention has for an orientation, up to their common sign.
inline Eigen::Vector4d encode_orientation(const Eigen::Matrix3d& earth_from_body,
                                          const OrientationConvention& convention) {
  const Eigen::Matrix3d axes_from_body = enu_from(convention.earth).transpose() * earth_from_body;
  const bool inverse = convention.orientation_of == OrientationOf::world_to_body;
  const Eigen::Quaterniond q(inverse ? axes_from_body.transpose() : axes_from_body);
  if (convention.quaternion == QuaternionOrder::wxyz) return {q.w(), q.x(), q.y(), q.z()};
  return q.coeffs();
}

}  // namespace plumbline
