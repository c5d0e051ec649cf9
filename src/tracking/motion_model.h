// How a hand moves: what is expected of the camera's position before the images are looked at.
#pragma once

#include "core/se3.h"

namespace plumbline {

/// A Gaussian of the camera's position, world frame.
struct PositionBelief {
  Eigen::Vector3d mean;        ///< metres
  Eigen::Matrix3d covariance;  ///< metres²
};

/// The velocity is an Ornstein-Uhlenbeck process (Uhlenbeck and Ornstein 1930): mean zero, a standard deviation, and a
/// time over which it is forgotten. Each tracked frame is a measurement of it, as good as the registration was in that
/// direction. So a prior on the position neither holds a camera back that is seen to move, as one with mean zero does,
/// nor goes on with a velocity that the images never showed.
class MotionModel {
 public:
  /// `sigma`: m/s. `memory`: seconds; 0 expects the camera to stay where it is (METHOD.md §6.2).
  MotionModel(double sigma, double memory);

  /// `seconds` after the last believed position.
  PositionBelief predict(const Eigen::Vector3d& last, double seconds) const;

  /// A position that is believed, `seconds` after the last one. `covariance`: of the position, prediction included.
  void observe(const Eigen::Vector3d& last, const Eigen::Vector3d& position, const Eigen::Matrix3d& covariance,
               double seconds);

 private:
  double sigma_, memory_;
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d variance_;
};

}  // namespace plumbline
