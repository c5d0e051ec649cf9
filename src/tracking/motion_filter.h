// An error-state Kalman filter around the registration (docs/method.md §8): propagated by the readings of a gyroscope
// and an accelerometer, or by steady motion without them, and corrected by the registered pose with its covariance.
//
// Frames: W world, C camera. Errors are in the world's axes: R = exp(δθ) R̂.
#pragma once

#include <vector>

#include "plumbline/imu.h"
#include "plumbline/parameters.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"

namespace plumbline {

/// What the filter knows: a value, which can be copied, kept and set back.
class MotionFilter {
 public:
  using Covariance = Eigen::Matrix<double, 19, 19>;

  explicit MotionFilter(const MotionParameters& parameters = {}) : parameters_(parameters) {}

  bool is_started() const { return is_started_; }
  /// Begins at a pose that is known. The readings, camera axes, tell where up is; there may be none.
  void start(const SE3& world_from_camera, Nanoseconds time, const std::vector<ImuSample>& readings);

  /// To the time of the next frame. `readings`: camera axes, ordered, those of the time between and, where they are
  /// known already, some before and after it, as the sensor's clock may be off. Where there are none, the camera goes
  /// on moving and turning as it did, ever less surely.
  void propagate(const std::vector<ImuSample>& readings, Nanoseconds time);

  /// A registered pose with its covariance, which has the prediction in it: (θ, t), world axes, radians and metres.
  void correct(const SE3& world_from_camera, const Matrix6d& covariance);

  /// How far the images alone turn the camera from the predicted pose: the squared distance normalised by both
  /// covariances, of three degrees of freedom. Arguments as of `correct`, before it. 0 where the images hold no
  /// rotation.
  double rotation_surprise(const SE3& world_from_camera, const Matrix6d& covariance) const;

  const SE3& world_from_camera() const { return world_from_camera_; }
  /// Of (θ, t), world axes, radians² and metres².
  Matrix6d pose_covariance() const { return covariance_.topLeftCorner<6, 6>(); }
  Nanoseconds time() const { return time_; }
  const Eigen::Vector3d& velocity() const { return velocity_; }              ///< m/s, world
  const Eigen::Vector3d& gravity() const { return gravity_; }                ///< m/s², world; zero without readings
  const Eigen::Vector3d& gyroscope_bias() const { return gyroscope_bias_; }  ///< rad/s, camera axes
  const Eigen::Vector3d& accelerometer_bias() const { return accelerometer_bias_; }  ///< m/s², camera axes
  /// Seconds by which the sensor's stamps are late: a frame's readings have its time and this.
  double lateness() const { return lateness_; }
  /// Whether the step to the present time was made by readings.
  bool is_inertial() const { return is_inertial_; }

 private:
  void follow_readings(const std::vector<ImuSample>& readings, Nanoseconds time);
  void remember(const std::vector<ImuSample>& readings);
  /// From one reading to the next, or a part of the way; `missed` is the part of the motion that is not seen between
  /// two.
  void step(const ImuSample& from, const ImuSample& to, double missed);
  void step_steadily(double seconds);
  void set_gravity(const Eigen::Vector3d& specific_force);

  MotionParameters parameters_;
  bool is_started_ = false, has_gravity_ = false, is_inertial_ = false;
  Nanoseconds time_ = 0;
  SE3 world_from_camera_;
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero(), gyroscope_bias_ = Eigen::Vector3d::Zero(),
                  accelerometer_bias_ = Eigen::Vector3d::Zero(), gravity_ = Eigen::Vector3d::Zero();
  double lateness_ = 0;                             ///< seconds
  std::vector<ImuSample> readings_;                 ///< of the recent time, ordered
  Eigen::Vector3d rate_ = Eigen::Vector3d::Zero();  ///< rad/s, camera axes, of the previous step
  SE3 previous_corrected_;                          ///< pose and time of the previous correction
  Nanoseconds previous_corrected_time_ = 0;
  Covariance covariance_ = Covariance::Zero();
};

}  // namespace plumbline
