// The filter to compare with: S. Madgwick, A. Harrison, R. Vaidyanathan, "Estimation of IMU and MARG orientation using
// a gradient descent algorithm", ICORR 2011.
#pragma once

#include <vector>

#include "plumbline/imu.h"
#include "plumbline/orientation.h"

namespace plumbline {

/// Gain of the authors' own implementation.
constexpr double kMadgwickGain = 0.1;

/// earth_from_body after each reading, x east, y north, z up. `gain`: their β, rad/s. Readings without a magnetic field
/// correct the tilt only. Starts from the first acceleration and field. Throws Error for readings without a gyroscope.
std::vector<OrientationSample> madgwick_orientation(const ImuRecording& recording, double gain = kMadgwickGain);

}  // namespace plumbline
