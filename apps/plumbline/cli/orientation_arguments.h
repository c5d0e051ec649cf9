// The options of an orientation sensor's readings.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "plumbline/parameters.h"
#include "sensor/orientation_stream.h"

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

/// All but --orientation itself are mistakes without it, or without --imu where the command has that.
void add_orientation_arguments(CLI::App& command, OrientationArguments& arguments);

/// The stream that the options describe; empty without --orientation. Throws UsageError for values that are not of
/// their option's form and a file that does not exist, Error for one that holds no orientations.
std::optional<OrientationStream> load_orientation(const OrientationArguments& arguments,
                                                  std::vector<std::string>* notes = nullptr);

/// The anchor's covariance of --sensor-model, if there is one. Throws Error for a file that is none.
void apply_sensor_model(const OrientationArguments& arguments, OrientationParameters* parameters);

/// How a sensor's readings are to be taken, whether they come from a file or from the sensor itself. Throws UsageError.
OrientationStreamOptions stream_options(const OrientationArguments& arguments);

/// File and error model, for summaries; empty without --orientation.
std::string describe(const OrientationArguments& arguments);

/// Lines of "name  value" for people: how many readings from where, notes on them, and whether they will be used.
std::vector<std::string> describe(const OrientationStream& stream, const std::string& source,
                                  const std::vector<std::string>& notes, const OrientationParameters& parameters);

}  // namespace plumbline::app
