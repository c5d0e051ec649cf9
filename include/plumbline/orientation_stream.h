// Orientations between the samples of a sensor.
//
// Frames: E earth (x east, y north, z up), B the sensor's body, C the camera.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "plumbline/export.h"
#include "plumbline/frame.h"
#include "plumbline/orientation.h"
#include "plumbline/time.h"

namespace plumbline {

enum class OrientationStatus { ok, before_start, after_end, gap };
/// In words: "gap in the orientation".
PLUMBLINE_EXPORT std::string_view to_string(OrientationStatus status);

struct OrientationReading {
  OrientationStatus status = OrientationStatus::gap;
  Eigen::Matrix3d earth_from_body = Eigen::Matrix3d::Identity();    ///< good if `status` is ok
  Eigen::Matrix3d earth_from_camera = Eigen::Matrix3d::Identity();  ///< good if `status` is ok
};

struct OrientationStreamOptions {
  double time_offset = 0;           ///< seconds, added to the sensor's stamps
  double max_gap = 0.1;             ///< seconds between two samples that are interpolated
  double max_extrapolation = 0.02;  ///< seconds beyond the last sample of an end or a gap
  Eigen::Matrix3d body_from_camera = Eigen::Matrix3d::Identity();
  OrientationConvention convention = {};  ///< that the samples were read with, for messages about it
};

class PLUMBLINE_EXPORT OrientationStream {
 public:
  /// Samples ordered by time, each stamp once. Throws Error if there are none, they are not so, one is no rotation, or
  /// an option is out of range.
  OrientationStream(std::vector<OrientationSample> samples, const OrientationStreamOptions& options);

  /// At a time of the camera's clock: at constant angular rate between two samples ("slerp"). Up to `max_extrapolation`
  /// beyond a sample that has no neighbour there the rate goes on that was measured over at least as long a time before
  /// it, so that a sample's error is grown by a factor of √5 at most; holding the sample would be wrong by 1° after
  /// 20 ms at a hand's 50°/s. Where there is no such time, the sample is held. O(log n).
  OrientationReading lookup(Nanoseconds time) const;

  const std::vector<OrientationSample>& samples() const { return samples_; }  ///< stamps of the camera's clock
  const OrientationStreamOptions& options() const { return options_; }

 private:
  OrientationReading reading(const Eigen::Matrix3d& earth_from_body) const;
  bool near(Nanoseconds earlier, Nanoseconds later) const;
  /// Beyond the sample `index` in the direction in which it has no neighbour.
  OrientationReading extrapolate(std::size_t index, Nanoseconds time) const;

  std::vector<OrientationSample> samples_;
  OrientationStreamOptions options_;
};

/// Gives the frame the camera's orientation at its time, where the stream has one and knows where up is. Returns what
/// the look-up said.
PLUMBLINE_EXPORT OrientationReading add_orientation(const OrientationStream& stream, Frame* frame);

}  // namespace plumbline
