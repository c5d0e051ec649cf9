#include "tracking/terms.h"

#include <Eigen/LU>
#include <algorithm>
#include <numbers>

namespace plumbline {

double registration_information(const TrackingParameters& parameters, int level_pixels) {
  constexpr double kReferencePixels = 320 * 240;
  const double redundancy = std::max(1.0, parameters.redundancy * level_pixels / kReferencePixels);
  return 1 / (redundancy * parameters.residual_sigma * parameters.residual_sigma);
}

Eigen::Matrix3d anchor_covariance(const OrientationParameters& parameters) {
  constexpr double kRadiansPerDegree = std::numbers::pi / 180;
  if (!parameters.covariance.empty())
    return Eigen::Matrix3d::Map(parameters.covariance.data()) * (kRadiansPerDegree * kRadiansPerDegree);
  const double tilt = parameters.tilt_sigma * kRadiansPerDegree, heading = parameters.heading_sigma * kRadiansPerDegree;
  return Eigen::Vector3d(tilt * tilt, tilt * tilt, heading * heading).asDiagonal();
}

kernels::OrientationAnchor orientation_anchor(const Eigen::Matrix3d& earth_from_camera,
                                              const Eigen::Matrix3d& earth_from_world,
                                              const Eigen::Matrix3d& covariance) {
  return {earth_from_camera, earth_from_world, covariance.inverse()};
}

kernels::TiltAnchor tilt_anchor(const Eigen::Matrix3d& earth_from_camera, const Eigen::Matrix3d& earth_from_world,
                                const Eigen::Matrix3d& covariance) {
  kernels::TiltAnchor anchor{earth_from_camera.row(2), earth_from_world, Eigen::Matrix3d::Zero()};
  anchor.information.topLeftCorner<2, 2>() = covariance.topLeftCorner<2, 2>().inverse();
  return anchor;
}

kernels::TranslationPrior translation_prior(const Eigen::Vector3d& expected, const Eigen::Matrix3d& covariance) {
  return {expected, covariance.inverse()};
}

}  // namespace plumbline
