// From angular rate, specific force and magnetic field to orientation: a filter of the VQF class.
//
// After D. Laidig, T. Seel, "VQF: Highly accurate IMU orientation estimation with bias estimation and magnetic
// disturbance rejection", Information Fusion 91, 2023 (arXiv 2203.17024); equation numbers are theirs, and so are the
// default values.
//
// Frames: B the sensor's body; I almost inertial: where the integrated gyroscope leads, it drifts slowly; L level: I
// turned so that the mean acceleration points up; E earth (x east, y north, z up): L turned about the vertical.
#pragma once

#include <vector>

#include "plumbline/imu.h"
#include "plumbline/orientation.h"

namespace plumbline {

/// Times in seconds, angles in radians.
struct OrientationFilterOptions {
  double tau_accelerometer = 3;  ///< of the low-pass whose output is taken for "up"
  double tau_magnetometer = 9;   ///< with which the heading follows the field

  double bias_initial_sigma = 0.5;                ///< °/s, as are the next four
  double bias_motion_sigma = 0.1;                 ///< what the bias settles to while moving
  double bias_rest_sigma = 0.03;                  ///< and at rest
  double bias_limit = 2;                          ///< of each axis
  double bias_walk = 0.1;                         ///< that the bias may wander …
  double bias_walk_time = 100;                    ///< … in this time
  double bias_vertical_forgetting = 1e-4;         ///< of the bias about the vertical, which nothing observes
  double rest_rate = 2, rest_acceleration = 0.5;  ///< °/s and m/s²: less deviation than this from the mean is rest …
  double rest_time = 1.5, rest_tau = 0.5;         ///< … after so long, the mean being a low-pass of rest_tau

  double field_tau = 0.05;          ///< smoothing of norm and dip
  double field_reference_tau = 20;  ///< with which the undisturbed field is followed
  double field_norm = 0.1;          ///< of the norm: farther from the reference the field is disturbed
  double field_dip = 10;            ///< °, the same of the dip
  double undisturbed_time = 0.5;    ///< before a field is used again
  double new_field_time = 20;       ///< a disturbed field that stays so while the sensor turns is the new reference
  double new_field_first_time = 5;  ///< the same where there is no reference yet
  double new_field_rate = 20;       ///< °/s of turning that counts for it
  double longest_rejection = 60;    ///< after which a disturbed field corrects the heading slowly
  double rejection_factor = 2;      ///< by which it is slower
};

/// The orientation after each reading, of the readings up to it. Interval between readings: `readings` decide (the
/// median); gaps are bridged at constant rate. Readings without a magnetic field leave the heading; without any, the
/// heading begins at an arbitrary value and drifts. Without a gyroscope, see `tilt_from_accelerometer`, without an
/// accelerometer `integrated_turns`. Throws Error for fewer than two readings, for readings without one of these two,
/// and for options out of range.
std::vector<OrientationSample> filter_orientation(const ImuRecording& recording,
                                                  const OrientationFilterOptions& options = {});

/// The same with all readings, those after it included: every low-pass runs forward and backward, and the bias is that
/// of two filters that meet (the paper's OfflineVQF).
std::vector<OrientationSample> smooth_orientation(const ImuRecording& recording,
                                                  const OrientationFilterOptions& options = {});

/// Gyroscope alone: the turns since the first reading, at which the body's axes are taken for the earth's; a bias stays
/// in. Throws Error for readings without a gyroscope.
std::vector<OrientationSample> integrated_turns(const ImuRecording& recording);

/// Seconds; on real hand motion (TUM fr1) near the smallest error of the tilt, forward and backward and forward only.
constexpr double kTiltTau = 0.1, kTiltTauForward = 0.03;

/// Accelerometer alone: the low-passed specific force is taken for "up". Between two readings the orientation turns
/// about a horizontal axis, so its heading means nothing. `tau` in seconds: short, as without a gyroscope the low-pass
/// must follow the turns. `both_ways`: forward and backward, without delay.
std::vector<OrientationSample> tilt_from_accelerometer(const ImuRecording& recording, double tau, bool both_ways);

}  // namespace plumbline
