// The options of an orientation sensor's readings.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "plumbline/imu.h"
#include "plumbline/parameters.h"
#include "plumbline/sequence.h"
#include "sensor/imu_stream.h"
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

/// Values of --orientation that name no file: the sensor of the recording, if it has one that serves; none.
constexpr std::string_view kAutoOrientation = "auto", kNoOrientation = "none";

/// All but --orientation itself are mistakes without it, or without --imu where the command has that. With `automatic`,
/// the recording's own sensor is the default.
void add_orientation_arguments(CLI::App& command, OrientationArguments& arguments, bool automatic = false);

/// Raw readings of a text file or of a recording, and how the depth camera sits on the sensor where that is known.
struct MountedImu {
  ImuRecording recording;
  std::optional<Eigen::Matrix3d> body_from_camera;
};
MountedImu load_imu(const std::string& path, std::vector<std::string>* notes);

/// What the sensor of a recording gives; without a stream, `unused` says why it is not used, or is empty where there is
/// no sensor.
struct RecordedOrientation {
  std::optional<ImuStream> inertial;  ///< the raw readings, where there are some
  std::optional<OrientationStream> stream;
  std::string source, unused;
  std::vector<std::string> notes;
};
RecordedOrientation recorded_orientation(const Sequence& sequence, const OrientationArguments& arguments);

/// Empty if a reading lies at any of the frames; else what to say: both spans of time, and what would bring them
/// together.
std::string overlap_problem(const OrientationStream& stream, const Sequence& sequence);

/// Empty if most frames have a reading, else a sentence with the stamps of both.
std::string coverage_note(const OrientationStream& stream, const Sequence& sequence);

/// The stream that the options describe; empty without a file. Throws UsageError for values that are not of
/// their option's form and a file that does not exist, Error for one that holds no orientations.
/// `inertial`: if given, gets the readings of a gyroscope and an accelerometer, where the file has them.
std::optional<OrientationStream> load_orientation(const OrientationArguments& arguments,
                                                  std::vector<std::string>* notes = nullptr,
                                                  std::optional<ImuStream>* inertial = nullptr);

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
