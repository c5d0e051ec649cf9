#include "tracking/model_fit.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace plumbline {
namespace {

/// How far a square is beyond that of the usual value: 0 up to it, 1 from twice as much on.
double beyond(double square, double usual) { return std::clamp(square / (usual * usual) - 1, 0.0, 1.0); }

}  // namespace

double least_known(const Eigen::Matrix3d& world_from_camera, const Matrix6d& solved, const Matrix6d& predicted,
                   double redundancy) {
  constexpr double kUsualDistance = 1.5;  // metres
  Matrix6d axes = Matrix6d::Zero();
  axes.topLeftCorner<3, 3>() = world_from_camera;
  axes.bottomRightCorner<3, 3>() = kUsualDistance * world_from_camera;
  const Matrix6d images = redundancy * (solved.inverse() - predicted.inverse());
  const Matrix6d scaled = axes.transpose() * images * axes;
  const Eigen::SelfAdjointEigenSolver<Matrix6d> directions(scaled, Eigen::EigenvaluesOnly);
  const double information = directions.eigenvalues()[0];
  return information > 0 ? 1 / std::sqrt(information) : kNothingKnown;
}

void ModelFit::observe(double rms, double least_known, double seconds) {
  constexpr double kMemory = 0.3;  // seconds
  const double square = rms * rms;
  square_ = square + std::exp(-seconds / kMemory) * (square_ - square);
  least_known_ = least_known;
}

// A Kinect in a room leaves 2 to 5 mrad in the direction that it tells least about, a phone's LiDAR 8 to 30.
double ModelFit::repeated_share() const {
  constexpr double kUsuallyKnown = 0.005;  // radians
  return std::max(beyond(square_, kNoise), beyond(least_known_ * least_known_, kUsuallyKnown));
}

}  // namespace plumbline
