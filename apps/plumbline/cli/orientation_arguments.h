// The options of an orientation sensor's readings.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "plumbline/orientation_stream.h"
#include "plumbline/parameters.h"
#include "plumbline/reconstruct.h"
#include "plumbline/sequence.h"

namespace CLI {
class App;
}

namespace plumbline::app {

struct OrientationArguments {
  std::string path, calibration, quaternion, orientation_of, earth, mounting, imu_model, sensor_model;
  std::optional<double> offset;                         // seconds
  double max_gap = OrientationStreamOptions{}.max_gap;  // seconds
  std::uint64_t imu_seed = 1;
};

/// Values of --orientation that name no file: the sensor of the recording, if it has one that serves; none.
constexpr std::string_view kAutoOrientation = "auto", kNoOrientation = "none";

/// All but --orientation itself are mistakes without it, or without --imu where the command has that. With `automatic`,
/// the recording's own sensor is the default.
void add_orientation_arguments(CLI::App& command, OrientationArguments& arguments, bool automatic = false);

/// What the sensor of a recording gives, taken as the options say; without a stream, `unused` says why it is not used,
/// or is empty where there is no sensor.
SensorReadings recorded_orientation(const Sequence& sequence, const OrientationArguments& arguments);

/// The readings that the options describe; empty without a file. Throws UsageError for values that are not of their
/// option's form and a file that does not exist, Error for one that holds no orientations.
SensorReadings load_orientation(const OrientationArguments& arguments);

/// The covariance of --sensor-model, if there is one: radians², earth axes. Throws Error for a file that is none.
std::optional<Eigen::Matrix3d> sensor_covariance(const OrientationArguments& arguments);

/// How a sensor's readings are to be taken, whether they come from a file or from the sensor itself. Throws UsageError.
OrientationStreamOptions stream_options(const OrientationArguments& arguments);

/// File and error model, for summaries; empty without --orientation.
std::string describe(const OrientationArguments& arguments);

/// Lines of "name  value" for people: how many readings from where, notes on them, and whether they will be used.
std::vector<std::string> describe(const OrientationStream& stream, const std::string& source,
                                  const std::vector<std::string>& notes, const OrientationParameters& parameters);

}  // namespace plumbline::app
