// What a characterisation found about a sensor, as a file.
#pragma once

#include <Eigen/Core>
#include <string>

#include "sensor/characterisation.h"
#include "sensor/error_model.h"

namespace plumbline::app {

struct SensorModel {
  OrientationErrorModel error;
  Eigen::Matrix3d covariance;  ///< radians², earth axes
};

/// TOML, angles in degrees.
void write_sensor_model(const std::string& path, const Characterisation& study);

/// Throws Error with file and line for what is missing or no number, and for a covariance that is not positive
/// definite.
SensorModel read_sensor_model(const std::string& path);

}  // namespace plumbline::app
