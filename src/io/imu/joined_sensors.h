// Gyroscope and accelerometer that were recorded apart, each at its own moments.
#pragma once

#include <vector>

#include "plumbline/imu.h"

namespace plumbline {

/// The samples of `rates` with the specific force of `forces` at their moments: between two of its samples, if these
/// are within 0.2 s. Samples without one are left out. Both by time.
std::vector<ImuSample> join_sensors(const std::vector<ImuSample>& rates, const std::vector<ImuSample>& forces);

}  // namespace plumbline
