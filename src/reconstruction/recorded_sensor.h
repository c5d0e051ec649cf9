// From a sensor's readings, in a recording or in a file, to streams on the camera's clock.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "plumbline/imu.h"
#include "plumbline/orientation_stream.h"
#include "plumbline/reconstruct.h"
#include "plumbline/sequence.h"

namespace plumbline {

/// Raw readings of a text file or of a recording, and how the depth camera sits on the sensor where that is known.
struct MountedImu {
  ImuRecording recording;
  std::optional<Eigen::Matrix3d> body_from_camera;
};
/// Throws Error for a file that has none.
MountedImu load_imu(const std::string& path, std::vector<std::string>* notes);

/// Empty if a reading lies at any of the frames; else what to say: both spans of time, and what would bring them
/// together.
std::string overlap_problem(const OrientationStream& stream, const Sequence& sequence);

/// Empty if most frames have a reading, else a sentence with the stamps of both.
std::string coverage_note(const OrientationStream& stream, const Sequence& sequence);

}  // namespace plumbline
