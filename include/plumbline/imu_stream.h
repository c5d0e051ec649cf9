// Raw readings of an inertial sensor, on the camera's clock and in the camera's axes.
#pragma once

#include <vector>

#include "plumbline/export.h"
#include "plumbline/frame.h"
#include "plumbline/imu.h"
#include "plumbline/time.h"

namespace plumbline {

class PLUMBLINE_EXPORT ImuStream {
 public:
  /// `time_offset`: seconds, added to the sensor's stamps. Throws Error for samples that are not ordered by time.
  ImuStream(ImuRecording recording, const Eigen::Matrix3d& body_from_camera, double time_offset);

  /// The readings of `from` ≤ t ≤ `to`, ordered.
  std::vector<ImuSample> between(Nanoseconds from, Nanoseconds to) const;

  const std::vector<ImuSample>& samples() const { return samples_; }  ///< camera's clock and axes

 private:
  std::vector<ImuSample> samples_;
};

}  // namespace plumbline
