// What was found in a sequence, in words.
#pragma once

#include <string>
#include <vector>

#include "plumbline/pinhole.h"
#include "plumbline/sequence.h"

namespace plumbline::app {

/// Lines of "name  value" for people: format, frames and rate, camera and where it was found, ground truth, notes.
std::vector<std::string> describe(const Sequence& sequence);

/// The same for the readings of an inertial sensor, at least one.
std::vector<std::string> describe(const ImuRecording& imu, const SequenceInfo& info);

/// "640x480, fx 517.3 fy 516.5 cx 318.6 cy 255.3".
std::string camera_text(const Pinhole& camera);

/// Median interval between frames and the longest one, seconds; zero for fewer than two frames.
struct Timing {
  double median_interval = 0, longest_gap = 0, longest_gap_start = 0;
  double duration = 0;
};
Timing timing(const Sequence& sequence);

}  // namespace plumbline::app
