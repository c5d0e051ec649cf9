#include "tracking/terms.h"

#include <Eigen/LU>
#include <algorithm>

namespace plumbline {

double registration_information(const TrackingParameters& parameters, int level_pixels) {
  // A Kinect's point-to-plane residual in metres. Only κσ² counts, so that κ is what one chooses.
  constexpr double kResidualSigma = 0.007;
  constexpr double kReferencePixels = 320 * 240;
  const double redundancy = std::max(1.0, parameters.redundancy * level_pixels / kReferencePixels);
  return 1 / (redundancy * kResidualSigma * kResidualSigma);
}

Eigen::Matrix3d anchor_covariance(const OrientationParameters& parameters) {
  const double tilt = parameters.tilt_sigma.radians(), heading = parameters.heading_sigma.radians();
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

kernels::PosePrior pose_prior(const SE3& expected, const Matrix6d& covariance) {
  return {expected, covariance.inverse()};
}

}  // namespace plumbline
