#include "sensor/orientation_filter.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <utility>

#include "core/median.h"
#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/orientation.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "sensor/low_pass.h"
#include "sensor/measured.h"

namespace plumbline {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr const char* kOrientationFilterWhere = "orientation filter";

double wrapped(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

/// Share of the way to its input that a first-order low-pass goes with each sample.
double gain_of(double tau, double interval) { return tau > 0 ? 1 - std::exp(-interval / tau) : 1; }

Quaterniond rotation_of(const Vector3d& vector) {
  const double angle = vector.norm();
  if (angle < 1e-12) return {1, vector.x() / 2, vector.y() / 2, vector.z() / 2};
  return Quaterniond(Eigen::AngleAxisd(angle, vector / angle));
}

Quaterniond about_up(double angle) { return {std::cos(angle / 2), 0, 0, std::sin(angle / 2)}; }

/// The rotation about a horizontal axis that turns a direction upright (equation 5).
Quaterniond upright(const Vector3d& direction) {
  const double w = std::sqrt(std::max(0.0, (direction.z() + 1) / 2));
  if (w < 1e-6) return {0, 1, 0, 0};
  return Quaterniond(w, direction.y() / (2 * w), -direction.x() / (2 * w), 0).normalized();
}

/// The sensor is at rest when rate and acceleration have been near their own means for a while (§3.6).
class RestDetector {
 public:
  RestDetector(const OrientationFilterOptions& o, double interval)
      : options_(o), interval_(interval), rate_(o.rest_tau, interval), force_(o.rest_tau, interval) {}

  void update(const Vector3d& rate, const Vector3d& force) {
    rate_.update(rate);
    force_.update(force);
    const bool steady = (rate - rate_.output()).norm() < radians(options_.rest_rate) &&
                        rate_.output().cwiseAbs().maxCoeff() <= radians(options_.bias_limit) &&
                        (force - force_.output()).norm() < options_.rest_acceleration;
    time_ = steady ? time_ + interval_ : 0;
  }

  bool at_rest() const { return time_ >= options_.rest_time; }
  const Vector3d& mean_rate() const { return rate_.output(); }

 private:
  const OrientationFilterOptions& options_;
  double interval_, time_ = 0;
  LowPass<3> rate_, force_;
};

/// Kalman filter of the gyroscope's bias, body axes (§3.5). At rest the mean rate is the bias. In motion a bias is what
/// tilts I against the mean acceleration: the correction's own rate, in level axes, shows its horizontal part. The
/// units of variances are (0.01 °/s)², which keeps the numbers near one.
class BiasEstimator {
 public:
  BiasEstimator(const OrientationFilterOptions& o, double interval)
      : options_(o),
        interval_(interval),
        rotation_(o.tau_accelerometer, interval),
        turned_(o.tau_accelerometer, interval) {
    const auto square = [](double x) { return x * x; };
    initial_ = square(100 * o.bias_initial_sigma);
    walk_ = square(100 * o.bias_walk) * interval / o.bias_walk_time;
    // The measurement's variance with which the filter settles to the wanted one (equation 27).
    const auto settling = [&](double sigma) { return square(square(100 * sigma)) / walk_ + square(100 * sigma); };
    motion_ = settling(o.bias_motion_sigma);
    rest_ = settling(o.bias_rest_sigma);
    vertical_ = motion_ / std::max(o.bias_vertical_forgetting, 1e-10);
    covariance_ = initial_ * Matrix3d::Identity();
  }

  const Vector3d& bias() const { return bias_; }
  const Matrix3d& covariance() const { return covariance_; }

  /// `up`: the low-passed acceleration before its correction, unit length, axes of L.
  void update(const RestDetector& rest, const Matrix3d& level_from_body, const Vector3d& up) {
    Matrix3d mean_rotation = Eigen::Map<const Matrix3d>(
        rotation_.update(Eigen::Map<const Eigen::Matrix<double, 9, 1>>(level_from_body.data())).data());
    const Vector2d turned = turned_.update((level_from_body * bias_).head<2>());
    Vector3d error, variance;
    if (rest.at_rest()) {
      error = rest.mean_rate() - bias_;
      mean_rotation.setIdentity();
      variance.setConstant(rest_);
    } else {
      const Vector3d removed = mean_rotation * bias_;
      error = Vector3d(-up.y() / interval_ + turned.x(), up.x() / interval_ + turned.y(), 0) - removed;
      variance = {motion_, motion_, vertical_};
    }
    correct(mean_rotation, error, variance);
  }

 private:
  void correct(const Matrix3d& observation, Vector3d error, const Vector3d& variance) {
    for (int i = 0; i < 3; ++i)
      if (covariance_(i, i) < initial_) covariance_(i, i) += walk_;
    const double limit = radians(options_.bias_limit);
    error = error.cwiseMax(-limit).cwiseMin(limit);
    Matrix3d innovation = observation * covariance_ * observation.transpose();
    innovation.diagonal() += variance;
    const Matrix3d gain = covariance_ * observation.transpose() * innovation.inverse();
    bias_ = (bias_ + gain * error).cwiseMax(-limit).cwiseMin(limit);
    covariance_ -= gain * observation * covariance_;
  }

  const OrientationFilterOptions& options_;
  double interval_, initial_, walk_, motion_, rest_, vertical_;
  Vector3d bias_ = Vector3d::Zero();
  Matrix3d covariance_;
  LowPass<9> rotation_;
  LowPass<2> turned_;
};

/// Whether the magnetic field is the earth's, by its norm and dip (§3.7).
class FieldMonitor {
 public:
  FieldMonitor(const OrientationFilterOptions& o, double interval)
      : options_(o),
        interval_(interval),
        gain_(gain_of(o.field_reference_tau, interval)),
        now_(o.field_tau, interval) {}

  /// `field`: axes of L. `turning`: rad/s.
  void update(const Vector3d& field, double turning) {
    const double norm = field.norm();
    const Vector2d now = now_.update({norm, -std::asin(std::clamp(field.z() / norm, -1.0, 1.0))});
    if (near(now, reference_)) {
      undisturbed_ += interval_;
      if (undisturbed_ >= options_.undisturbed_time) {
        disturbed_ = false;
        reference_ += gain_ * (now - reference_);
      }
    } else {
      undisturbed_ = 0;
      disturbed_ = true;
    }
    consider(now, turning);
  }

  bool disturbed() const { return disturbed_; }

 private:
  bool near(const Vector2d& now, const Vector2d& other) const {
    return std::abs(now[0] - other[0]) < options_.field_norm * other[0] &&
           std::abs(now[1] - other[1]) < radians(options_.field_dip);
  }

  /// A field that stays the same while the sensor turns is accepted in place of the reference.
  void consider(const Vector2d& now, double turning) {
    if (!near(now, candidate_)) {
      candidate_time_ = 0;
      candidate_ = now;
      return;
    }
    if (turning >= radians(options_.new_field_rate)) candidate_time_ += interval_;
    candidate_ += gain_ * (now - candidate_);
    const bool first = reference_[0] == 0;
    const double needed = first ? options_.new_field_first_time : options_.new_field_time;
    if (!disturbed_ || candidate_time_ < needed) return;
    reference_ = candidate_;
    disturbed_ = false;
    undisturbed_ = options_.undisturbed_time;
  }

  const OrientationFilterOptions& options_;
  double interval_, gain_;
  LowPass<2> now_;
  Vector2d reference_ = Vector2d::Zero(), candidate_ = Vector2d::Zero();  ///< norm, dip (radians)
  double undisturbed_ = 0, candidate_time_ = 0;
  bool disturbed_ = true;
};

/// The heading of L in E follows the field's (§3.4), not at all where it is disturbed, and slowly if it stays so.
class HeadingFollower {
 public:
  HeadingFollower(const OrientationFilterOptions& o, double interval)
      : options_(o), interval_(interval), gain_(gain_of(o.tau_magnetometer, interval)) {}

  /// From here on without the fast start.
  void start_at(double heading) {
    heading_ = heading;
    fast_ = 0;
  }

  double update(double measured, bool disturbed) {
    double gain = gain_;
    if (!disturbed) {
      rejected_ = std::max(0.0, rejected_ - options_.rejection_factor * interval_);
    } else if (rejected_ <= options_.longest_rejection) {
      rejected_ += interval_;
      gain = 0;
    } else {
      gain /= options_.rejection_factor;
    }
    if (fast_ > 0) {  // the mean of the first readings
      gain = std::max(gain, fast_);
      fast_ = fast_ / (fast_ + 1);
      if (fast_ < gain_) fast_ = 0;
    }
    heading_ = wrapped(heading_ + gain * wrapped(measured - heading_));
    return heading_;
  }

  double heading() const { return heading_; }

 private:
  const OrientationFilterOptions& options_;
  double interval_, gain_, heading_ = 0, rejected_ = 0, fast_ = 1;
};

/// Angle about up that turns a field in level axes to the north.
double heading_of(const Vector3d& field) { return std::atan2(field.x(), field.y()); }

/// The filter that sees only the past.
class ForwardFilter {
 public:
  ForwardFilter(const OrientationFilterOptions& o, double interval)
      : rest_(o, interval),
        bias_(o, interval),
        field_(o, interval),
        heading_(o, interval),
        force_(o.tau_accelerometer, interval) {}

  /// `seconds`: since the previous reading; zero for the first.
  void update(const ImuSample& reading, double seconds) {
    if (is_measured(reading.specific_force)) rest_.update(reading.angular_rate, reading.specific_force);
    inertial_from_body_ =
        (inertial_from_body_ * rotation_of(seconds * (reading.angular_rate - bias_.bias()))).normalized();
    if (is_measured(reading.specific_force)) level(reading.specific_force);
    if (is_measured(reading.magnetic_field)) {
      const Vector3d field = level_from_body() * *reading.magnetic_field;
      field_.update(field, rest_.mean_rate().norm());
      heading_.update(heading_of(field), field_.disturbed());
    }
  }

  Quaterniond level_from_body() const { return level_from_inertial_ * inertial_from_body_; }
  Quaterniond earth_from_body() const { return about_up(heading_.heading()) * level_from_body(); }
  const BiasEstimator& bias() const { return bias_; }
  bool disturbed() const { return field_.disturbed(); }

 private:
  void level(const Vector3d& specific_force) {
    const Vector3d up = (level_from_inertial_ * force_.update(inertial_from_body_ * specific_force)).normalized();
    level_from_inertial_ = (upright(up) * level_from_inertial_).normalized();
    bias_.update(rest_, level_from_body().toRotationMatrix(), up);
  }

  RestDetector rest_;
  BiasEstimator bias_;
  FieldMonitor field_;
  HeadingFollower heading_;
  LowPass<3> force_;
  Quaterniond inertial_from_body_ = Quaterniond::Identity(), level_from_inertial_ = Quaterniond::Identity();
};

void validate(const OrientationFilterOptions& o) {
  const double positive[] = {o.tau_accelerometer, o.tau_magnetometer,  o.bias_initial_sigma,  o.bias_motion_sigma,
                             o.bias_rest_sigma,   o.bias_limit,        o.bias_walk,           o.bias_walk_time,
                             o.rest_rate,         o.rest_acceleration, o.field_reference_tau, o.rejection_factor};
  for (const double value : positive)
    if (!(value > 0 && value < 1e9))
      throw Error("an option is not positive", kOrientationFilterWhere, "give times and limits above 0");
}

/// Seconds between two readings, the median.
double interval_of(const std::vector<ImuSample>& readings) {
  if (readings.size() < 2)
    throw Error("there are fewer than two readings", kOrientationFilterWhere, "give a recording");
  std::vector<double> intervals;
  for (std::size_t i = 1; i < readings.size(); ++i)
    intervals.push_back(to_seconds(readings[i].time - readings[i - 1].time));
  const double interval = median(std::move(intervals));
  if (!(interval > 0)) throw Error("the readings are not ordered by time", kOrientationFilterWhere, "sort them");
  return interval;
}

double seconds_before(const std::vector<ImuSample>& readings, std::size_t i) {
  return i == 0 ? 0 : to_seconds(readings[i].time - readings[i - 1].time);
}

void require_sensors(const ImuRecording& recording) {
  if (!recording.has_accelerometer)
    throw Error("there is no accelerometer in the readings, so that nothing says where up is", kOrientationFilterWhere,
                "`plumbline run --orientation` takes a gyroscope alone");
  if (!recording.has_gyroscope)
    throw Error("there is no gyroscope in the readings", kOrientationFilterWhere,
                "an accelerometer alone gives the tilt");
}

/// The same motion as it would have been measured if time ran backwards.
std::vector<ImuSample> reversed(std::vector<ImuSample> readings) {
  std::reverse(readings.begin(), readings.end());
  for (ImuSample& r : readings) {
    r.time = -r.time;
    r.angular_rate = -r.angular_rate;
  }
  return readings;
}

/// What a forward filter knew after each reading.
struct Pass {
  std::vector<Vector3d> bias;
  std::vector<Matrix3d> information;  ///< of the bias
  std::vector<char> disturbed;
};

Pass run_pass(const std::vector<ImuSample>& readings, const OrientationFilterOptions& options, double interval) {
  ForwardFilter filter(options, interval);
  Pass pass;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    filter.update(readings[i], seconds_before(readings, i));
    pass.bias.push_back(filter.bias().bias());
    pass.information.push_back(filter.bias().covariance().inverse());
    pass.disturbed.push_back(filter.disturbed() ? 1 : 0);
  }
  return pass;
}

/// The bias of two filters that meet, and what both hold for a disturbed field.
Pass meet(const Pass& forward, const Pass& backward) {
  Pass both = forward;
  const std::size_t n = forward.bias.size();
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t mirrored = n - 1 - i;
    const Matrix3d& a = forward.information[i];
    const Matrix3d& b = backward.information[mirrored];
    both.information[i] = a + b;
    both.bias[i] = both.information[i].inverse() * (a * forward.bias[i] - b * backward.bias[mirrored]);
    both.disturbed[i] = forward.disturbed[i] != 0 && backward.disturbed[mirrored] != 0 ? 1 : 0;
  }
  return both;
}

/// level_from_body with a bias that is known and a low-pass without delay.
std::vector<Quaterniond> level_both_ways(const std::vector<ImuSample>& readings, const std::vector<Vector3d>& bias,
                                         const OrientationFilterOptions& options, double interval) {
  std::vector<Quaterniond> orientation;
  std::vector<Vector3d> force;
  Quaterniond inertial_from_body = Quaterniond::Identity();
  Vector3d previous = Vector3d::Zero();
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const Vector3d turn = seconds_before(readings, i) * (readings[i].angular_rate - bias[i]);
    inertial_from_body = (inertial_from_body * rotation_of(turn)).normalized();
    if (is_measured(readings[i].specific_force)) previous = inertial_from_body * readings[i].specific_force;
    orientation.push_back(inertial_from_body);
    force.push_back(previous);
  }
  force = low_pass_both_ways<3>(std::move(force), options.tau_accelerometer, interval);
  Quaterniond level_from_inertial = Quaterniond::Identity();
  for (std::size_t i = 0; i < readings.size(); ++i) {
    level_from_inertial = (upright((level_from_inertial * force[i]).normalized()) * level_from_inertial).normalized();
    orientation[i] = level_from_inertial * orientation[i];
  }
  return orientation;
}

/// Heading of L in E, low-passed forward and backward.
std::vector<double> headings_both_ways(const std::vector<ImuSample>& readings,
                                       const std::vector<Quaterniond>& level_from_body,
                                       const std::vector<char>& disturbed, const OrientationFilterOptions& options,
                                       double interval) {
  const std::size_t n = readings.size();
  std::vector<double> heading(n, 0);
  HeadingFollower forward(options, interval);
  for (std::size_t i = 0; i < n; ++i) {
    if (is_measured(readings[i].magnetic_field))
      forward.update(heading_of(level_from_body[i] * *readings[i].magnetic_field), disturbed[i] != 0);
    heading[i] = forward.heading();
  }
  HeadingFollower backward(options, interval);
  backward.start_at(heading.back());
  for (std::size_t i = n; i-- > 0;) heading[i] = backward.update(heading[i], disturbed[i] != 0);
  return heading;
}

}  // namespace

std::vector<OrientationSample> filter_orientation(const ImuRecording& recording,
                                                  const OrientationFilterOptions& options) {
  validate(options);
  require_sensors(recording);
  ForwardFilter filter(options, interval_of(recording.samples));
  std::vector<OrientationSample> samples;
  for (std::size_t i = 0; i < recording.samples.size(); ++i) {
    filter.update(recording.samples[i], seconds_before(recording.samples, i));
    samples.push_back({recording.samples[i].time, filter.earth_from_body().toRotationMatrix()});
  }
  return samples;
}

std::vector<OrientationSample> smooth_orientation(const ImuRecording& recording,
                                                  const OrientationFilterOptions& options) {
  validate(options);
  require_sensors(recording);
  const std::vector<ImuSample>& readings = recording.samples;
  const double interval = interval_of(readings);
  const Pass both = meet(run_pass(readings, options, interval), run_pass(reversed(readings), options, interval));
  const std::vector<Quaterniond> level = level_both_ways(readings, both.bias, options, interval);
  std::vector<double> heading(readings.size(), 0);
  if (recording.has_magnetometer) heading = headings_both_ways(readings, level, both.disturbed, options, interval);
  std::vector<OrientationSample> samples;
  for (std::size_t i = 0; i < readings.size(); ++i)
    samples.push_back({readings[i].time, (about_up(heading[i]) * level[i]).normalized().toRotationMatrix()});
  return samples;
}

namespace {

std::vector<Vector3d> smoothed_force(const ImuRecording& recording, double tau, bool both_ways) {
  const double interval = interval_of(recording.samples);
  std::vector<Vector3d> force;
  for (const ImuSample& reading : recording.samples) force.push_back(reading.specific_force);
  if (both_ways) return low_pass_both_ways<3>(std::move(force), tau, interval);
  LowPass<3> filter(tau, interval);
  for (Vector3d& f : force) f = filter.update(f);
  return force;
}

}  // namespace

std::vector<OrientationSample> tilt_from_accelerometer(const ImuRecording& recording, double tau, bool both_ways) {
  if (!(tau >= 0 && tau < 1e6))
    throw Error("the time constant is out of range", kOrientationFilterWhere, "give seconds from 0");
  const std::vector<Vector3d> force = smoothed_force(recording, tau, both_ways);
  std::vector<OrientationSample> samples;
  Quaterniond earth_from_body = Quaterniond::Identity();
  for (std::size_t i = 0; i < force.size(); ++i) {
    earth_from_body = (upright((earth_from_body * force[i]).normalized()) * earth_from_body).normalized();
    samples.push_back({recording.samples[i].time, earth_from_body.toRotationMatrix()});
  }
  return samples;
}

std::vector<OrientationSample> integrated_turns(const ImuRecording& recording) {
  if (!recording.has_gyroscope)
    throw Error("there is no gyroscope in the readings", kOrientationFilterWhere,
                "an accelerometer alone gives the tilt");
  const std::vector<ImuSample>& readings = recording.samples;
  std::vector<OrientationSample> samples;
  Quaterniond first_from_body = Quaterniond::Identity();
  for (std::size_t i = 0; i < readings.size(); ++i) {
    if (i > 0) {
      const Vector3d turn = seconds_before(readings, i) * (readings[i - 1].angular_rate + readings[i].angular_rate) / 2;
      first_from_body = (first_from_body * Quaterniond(so3::exp(turn))).normalized();
    }
    samples.push_back({readings[i].time, first_from_body.toRotationMatrix()});
  }
  return samples;
}

}  // namespace plumbline
