// The time offset between a camera and an orientation sensor, from how fast both turn.
#pragma once

#include <vector>

#include "plumbline/calibration.h"
#include "plumbline/orientation_stream.h"
#include "plumbline/trajectory.h"

namespace plumbline {

struct OffsetCandidate {
  double offset = 0;       ///< seconds, to be added to the sensor's stamps
  double correlation = 0;  ///< of the angular speeds, −1…1
};

/// Offsets at which the angular speeds of both correlate best, the best first. An angular speed is the same in every
/// frame, so neither the mounting nor the earth's axes matter (Mair, Fleps, Suppa, Burschka, "Spatio-temporal
/// initialization for IMU to camera registration", 2011). A motion that repeats has several peaks. Empty if they share
/// less than ten speeds at every offset, or one side's does not vary. `sensor` has no time offset of its own.
std::vector<OffsetCandidate> correlate_angular_speed(const Trajectory& camera, const OrientationStream& sensor,
                                                     const OffsetSearch& search = {});

}  // namespace plumbline
