// How people name the columns of inertial readings.
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "io/columns.h"

namespace plumbline {

enum ImuSensor { kGyroscope, kAccelerometer, kMagnetometer, kSensors };

/// Whose component a column is by its name, in lower case, and which one, 0…2.
std::optional<std::pair<ImuSensor, int>> component_of(const std::string& name);

/// A unit at the end of a name, as in gyro_x_dps, put where those in brackets are.
ColumnName with_unit_apart(ColumnName column);

/// Columns x, y and z in a file that has the sensor in its name, as Gyroscope.csv, get names of that sensor's.
std::vector<ColumnName> named_by_file(std::vector<ColumnName> names, const std::string& path);

}  // namespace plumbline
