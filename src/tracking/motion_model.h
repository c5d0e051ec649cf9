// How a hand moves: what is expected of the camera before the images are looked at.
#pragma once

#include "plumbline/se3.h"

namespace plumbline {

/// A Gaussian of the camera's position, world frame.
struct PositionPrediction {
  Eigen::Vector3d mean;        ///< metres
  Eigen::Matrix3d covariance;  ///< metres²
};

/// The velocity is an Ornstein-Uhlenbeck process (Uhlenbeck and Ornstein 1930): mean zero, a standard deviation, and a
/// time over which it is forgotten. Each tracked frame is a measurement of it, as good as the registration was in that
/// direction. So a prior on the position neither holds a camera back that is seen to move, as one with mean zero does,
/// nor goes on with a velocity that the images never showed.
class MotionModel {
 public:
  /// `sigma`: m/s. `memory`: seconds; 0 expects the camera to stay where it is (docs/method.md §6.2).
  MotionModel(double sigma, double memory);

  /// `seconds` after the previous accepted position.
  PositionPrediction predict(const Eigen::Vector3d& previous, double seconds) const;

  /// An accepted position, `seconds` after the previous one. `covariance`: of the position, prediction included.
  void observe(const Eigen::Vector3d& previous, const Eigen::Vector3d& position, const Eigen::Matrix3d& covariance,
               double seconds);

 private:
  double sigma_, memory_;
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d variance_;
};

/// A turn that goes on: from one tracked frame to the next a hand's angular rate changes less than the hand turns. Only
/// a place to start from, never a term in the solve.
class SteadyTurn {
 public:
  /// `seconds` after `previous`, world_from_camera.
  Eigen::Matrix3d predict(const Eigen::Matrix3d& previous, double seconds) const;

  /// An accepted rotation, `seconds` after the previous one.
  void observe(const Eigen::Matrix3d& previous, const Eigen::Matrix3d& rotation, double seconds);
  /// After a lost frame nothing is expected to go on.
  void forget() { rate_.setZero(); }

 private:
  Eigen::Vector3d rate_ = Eigen::Vector3d::Zero();  ///< radians per second, camera's axes
};

}  // namespace plumbline
