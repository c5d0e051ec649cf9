// How far an orientation sensor can be trusted: the study of Giancola, Schneider, Wonka, Ghanem 2018, §5, in the terms
// of the GUM (JCGM 100:2008).
//
// A rotary table (or any reference) turns the sensor about one earth axis after the other and rests; the readings of
// each rest are compared with the reference. Frames: E earth (x east, y north, z up), B the sensor's body.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "plumbline/orientation.h"
#include "sensor/error_model.h"

namespace plumbline {

struct CharacterisationOptions {
  double settling = 5;              ///< seconds of each rest that are left out: the chip's own low-pass
  double still = 0.0009;            ///< radians: the reference rests while it moves less
  double off_axis = 0.087;          ///< radians: a rest belongs to an axis if it is turned less than this about others
  std::size_t fewest_readings = 2;  ///< of a rest
  int harmonics = 6;                ///< of the fitted functions; fewer where there are few angles
};

/// The readings of one rest, about the axis that was turned. Radians.
struct RestReadings {
  double angle = 0;       ///< of the reference about the axis, (−π, π]
  std::size_t count = 0;  ///< of readings
  double systematic = 0;  ///< mean of the readings less the reference
  double random = 0;      ///< standard deviation of the readings

  double combined() const;                            ///< standard uncertainty, both in quadrature
  double expanded() const { return 2 * combined(); }  ///< k = 2, about 95 %
};

/// One axis. Radians.
struct AxisStudy {
  std::vector<RestReadings> rests;  ///< by angle; empty if the axis was not turned
  double amplitude = 0;             ///< largest systematic part, in magnitude
  double systematic = 0;            ///< rms over the rests
  double random = 0;                ///< the same
  PeriodicError fit;                ///< the systematic part as a function of the angle

  double combined() const;
};

struct Characterisation {
  std::array<AxisStudy, 3> axes;  ///< about east, north (tilt) and up (heading)
  std::vector<std::string> notes;

  /// radians², earth axes, diagonal: combined uncertainties over all angles. For an axis that was not turned the other
  /// tilt's, or the greatest.
  Eigen::Matrix3d covariance() const;
  /// To degrade an ideal orientation in the same way.
  OrientationErrorModel model() const;
};

/// `reference`: earth_from_body of the table, at least two stamps a rest (its begin and its end). `readings`: the
/// sensor's, same earth axes and clock. Both ordered by time. Throws Error where no rest has readings.
Characterisation characterise(const std::vector<OrientationSample>& reference,
                              const std::vector<OrientationSample>& readings,
                              const CharacterisationOptions& options = {});

}  // namespace plumbline
