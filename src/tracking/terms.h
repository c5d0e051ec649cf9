// The terms of kernels/terms.h from what sensors and parameters say.
#pragma once

#include "kernels/terms.h"
#include "plumbline/parameters.h"

namespace plumbline {

/// What one pixel's squared residual weighs beside a prior, 1/κσ²: neighbouring pixels are not independent
/// (docs/method.md §6.4). κ is that of an image of 320×240; it goes with the number of pixels, so that an image tells
/// the same at every size.
double registration_information(const TrackingParameters& parameters, int level_pixels);

/// The covariance of the parameters, radians², earth axes (east, north, up).
Eigen::Matrix3d anchor_covariance(const OrientationParameters& parameters);

/// `covariance`: radians², earth axes, positive definite.
kernels::OrientationAnchor orientation_anchor(const Eigen::Matrix3d& earth_from_camera,
                                              const Eigen::Matrix3d& earth_from_world,
                                              const Eigen::Matrix3d& covariance);

/// `covariance`: radians², earth axes; its horizontal part counts.
kernels::TiltAnchor tilt_anchor(const Eigen::Matrix3d& earth_from_camera, const Eigen::Matrix3d& earth_from_world,
                                const Eigen::Matrix3d& covariance);

/// `covariance`: metres², positive definite.
kernels::TranslationPrior translation_prior(const Eigen::Vector3d& expected, const Eigen::Matrix3d& covariance);

/// `covariance`: of (θ, t), world axes, radians² and metres², positive definite.
kernels::PosePrior pose_prior(const SE3& expected, const Matrix6d& covariance);

}  // namespace plumbline
