#include "tracking/orientation_guide.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>

#include "plumbline/error.h"

namespace plumbline {
namespace {

// A third of a second at 30 Hz: long enough for a turn to stand out of the tracker's own error, short beside the
// periods of a sensor's systematic error.
constexpr std::size_t kSpanFrames = 10;
constexpr std::size_t kMinSpanFrames = 4;
constexpr double kDecay = 0.95;  // the latest twenty spans count
constexpr double kMinSpans = 3;  // before these there is no judgement
constexpr double kRegain = 0.5;  // of the limit: trust comes back later than it goes

/// The tilt of an orientation alone: the turn about a horizontal axis that brings up, as it is in the world, where it
/// is in the camera.
Eigen::Matrix3d tilt_of(const Eigen::Matrix3d& earth_from_camera, const Eigen::Matrix3d& earth_from_world) {
  const Eigen::Vector3d up_in_camera = earth_from_camera.row(2), up_in_world = earth_from_world.row(2);
  return Eigen::Quaterniond::FromTwoVectors(up_in_camera, up_in_world).toRotationMatrix();
}

bool is_covariance(const Eigen::Matrix3d& matrix) {
  return matrix.isApprox(matrix.transpose(), 1e-9) && Eigen::LLT<Eigen::Matrix3d>(matrix).info() == Eigen::Success;
}

}  // namespace

std::string_view to_string(OrientationUse use) {
  switch (use) {
    case OrientationUse::off:
      return "";
    case OrientationUse::missing:
      return "missing";
    case OrientationUse::first:
      return "first";
    case OrientationUse::used:
      return "used";
    case OrientationUse::distrusted:
      return "disagrees with tracking";
    case OrientationUse::dropped:
      return "tracked better without";
  }
  return "unknown";
}

void OrientationMonitor::observe(const Eigen::Matrix3d& earth_from_camera, const Eigen::Matrix3d& world_from_camera) {
  history_.push_back({earth_from_camera, world_from_camera});
  if (history_.size() > kSpanFrames + 1) history_.pop_front();
  if (distrust_ <= 0 || history_.size() <= kMinSpanFrames) return;
  const Pair& then = history_.front();
  const Eigen::Matrix3d sensor_turn = then.earth_from_camera.transpose() * earth_from_camera;
  const Eigen::Matrix3d tracked_turn = then.world_from_camera.transpose() * world_from_camera;
  const double missed = so3::angle(sensor_turn.transpose() * tracked_turn), turned = so3::angle(tracked_turn);
  missed_ = kDecay * missed_ + missed * missed;
  turned_ = kDecay * turned_ + turned * turned;
  count_ = kDecay * count_ + 1;
  if (count_ < kMinSpans) return;
  const double limit = distrust_ * turned_ + floor_ * floor_ * count_;
  trusted_ = missed_ <= (trusted_ ? limit : kRegain * limit);
}

OrientationGuide::OrientationGuide(const OrientationParameters& parameters, const OrientationSensor& sensor)
    : parameters_(parameters),
      sensor_(sensor),
      // An accelerometer takes the hand's acceleration for tilt: it may err by its own sigma from span to span.
      monitor_(parameters.distrust, sensor.has_heading
                                        ? OrientationMonitor::kFloor
                                        : std::max(OrientationMonitor::kFloor, parameters.tilt_sigma.radians())) {
  if (sensor.covariance && !is_covariance(*sensor.covariance))
    throw Error("the matrix is not symmetric and positive definite", "OrientationSensor::covariance",
                "Give radians^2 about the earth's axes, or leave it empty for tilt_sigma and heading_sigma.");
}

bool uses_sensor(const OrientationParameters& parameters) {
  return parameters.seed != OrientationSeed::none || parameters.term != OrientationTerm::none;
}

OrientationUse OrientationGuide::use(const std::optional<Eigen::Matrix3d>& earth_from_camera) const {
  if (!is_on()) return OrientationUse::off;
  if (!earth_from_camera) return OrientationUse::missing;
  if (!monitor_.trusted()) return OrientationUse::distrusted;
  return earth_from_world_ ? OrientationUse::used : OrientationUse::first;
}

SE3 OrientationGuide::seed(const SE3& previous, const Eigen::Matrix3d& earth_from_camera) const {
  if (!sensor_.has_heading) return previous;
  switch (parameters_.seed) {
    case OrientationSeed::none:
      return previous;
    case OrientationSeed::absolute:
      return {earth_from_world_->transpose() * earth_from_camera, previous.translation()};
    case OrientationSeed::relative:
      if (!reference_) return previous;  // the previous accepted frame had no reading
      return {reference_->world_from_camera * reference_->earth_from_camera.transpose() * earth_from_camera,
              previous.translation()};
  }
  return previous;
}

std::vector<SE3> OrientationGuide::starts(const SE3& seed, const Eigen::Matrix3d& earth_from_camera) const {
  constexpr double kOfTurn = 0.5, kSigmas = 1.5;  // how far the heading may be wrong
  std::vector<SE3> starts = {seed};
  if (parameters_.search.radians() <= 0 || !sensor_.has_heading || !reference_ || !earth_from_world_) return starts;
  const double turned = so3::angle(reference_->earth_from_camera.transpose() * earth_from_camera),
               step = parameters_.search.radians(),
               farthest = std::min(kOfTurn * turned, kSigmas * parameters_.heading_sigma.radians());
  const Eigen::Vector3d up = earth_from_world_->row(2);  // in the world
  for (double heading = step; heading <= farthest; heading += step)
    for (const double offset : {-heading, heading})
      starts.emplace_back(so3::exp(Eigen::Vector3d(offset * up)) * seed.rotation(), seed.translation());
  return starts;
}

void OrientationGuide::add_term(const Eigen::Matrix3d& earth_from_camera, kernels::Terms* terms) const {
  switch (parameters_.term) {
    case OrientationTerm::none:
      return;
    case OrientationTerm::damping:
      return terms->set(kernels::RotationDamping{parameters_.schedule, parameters_.lambda});
    case OrientationTerm::anchor:
      const Eigen::Matrix3d covariance = sensor_.covariance.value_or(anchor_covariance(parameters_));
      if (sensor_.has_heading) return terms->set(orientation_anchor(earth_from_camera, *earth_from_world_, covariance));
      return terms->set(tilt_anchor(earth_from_camera, *earth_from_world_, covariance));
  }
}

void OrientationGuide::observe(const SE3& world_from_camera, const std::optional<Eigen::Matrix3d>& earth_from_camera,
                               const std::optional<Eigen::Matrix3d>& witness) {
  reference_.reset();
  if (!is_on() || !earth_from_camera) return;
  if (witness) judge(*earth_from_camera, *witness);
  if (!monitor_.trusted()) {
    if (sensor_.has_heading) earth_from_world_.reset();  // tied anew when trust comes back
    return;
  }
  reference_ = Reference{world_from_camera.rotation(), *earth_from_camera};
  if (!earth_from_world_) earth_from_world_ = *earth_from_camera * world_from_camera.rotation().transpose();
}

void OrientationGuide::judge(const Eigen::Matrix3d& earth_from_camera, const Eigen::Matrix3d& world_from_camera) {
  if (sensor_.has_heading) {
    monitor_.observe(earth_from_camera, world_from_camera);
  } else if (earth_from_world_) {  // which says where up is in the world
    monitor_.observe(tilt_of(earth_from_camera, *earth_from_world_),
                     tilt_of(*earth_from_world_ * world_from_camera, *earth_from_world_));
  }
}

}  // namespace plumbline
