#include "plumbline/imu_stream.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "plumbline/error.h"

namespace plumbline {
namespace {

bool is_before(const ImuSample& sample, Nanoseconds time) { return sample.time < time; }

}  // namespace

ImuStream::ImuStream(ImuRecording recording, const Eigen::Matrix3d& body_from_camera, double time_offset)
    : samples_(std::move(recording.samples)) {
  const Eigen::Matrix3d camera_from_body = body_from_camera.transpose();
  const Nanoseconds offset = from_seconds(time_offset);
  for (ImuSample& sample : samples_) {
    sample.time += offset;
    sample.angular_rate = camera_from_body * sample.angular_rate;
    sample.specific_force = camera_from_body * sample.specific_force;
    if (sample.magnetic_field) sample.magnetic_field = camera_from_body * *sample.magnetic_field;
  }
  for (std::size_t i = 1; i < samples_.size(); ++i)
    if (samples_[i].time <= samples_[i - 1].time)
      throw Error("the readings are not ordered by time", "inertial sensor", "Sort them, each stamp once.");
}

std::vector<ImuSample> ImuStream::between(Nanoseconds from, Nanoseconds to) const {
  const auto first = std::lower_bound(samples_.begin(), samples_.end(), from, is_before),
             end = std::lower_bound(first, samples_.end(), to + 1, is_before);
  return {first, end};
}

}  // namespace plumbline
