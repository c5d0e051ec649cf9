// How far the images can be trusted beside a prediction: by what they leave unexplained, and by what they say least
// about.
#pragma once

#include <limits>

#include "plumbline/se3.h"

namespace plumbline {

/// Of images that hold no direction.
constexpr double kNothingKnown = std::numeric_limits<double>::infinity();

/// Standard deviation of the direction that the images alone tell least about, as an angle seen from the camera:
/// radians, metres at 1.5 m. `solved` and `predicted` are covariances of (θ, t) in world axes; the images count for
/// 1/`redundancy` in `solved`.
double least_known(const Eigen::Matrix3d& world_from_camera, const Matrix6d& solved, const Matrix6d& predicted,
                   double redundancy);

/// Whether the latest frames fit the model like noise, and hold the camera in all directions. What residuals have
/// beyond a good sensor's noise is no noise of single pixels but error that successive frames share, and so is what is
/// known of a direction in which hardly anything holds (docs/method.md §8).
class ModelFit {
 public:
  /// `rms`: metres, point-to-plane, of an accepted frame.
  void observe(double rms, double least_known, double seconds);
  /// 0 where frames fit as well as a good sensor's and tell all directions, 1 where half of the residual's square and
  /// more is shared error or a direction is hardly told, and before anything is known.
  double repeated_share() const;

 private:
  /// Metres: frames of a Kinect in a room are below, in views of its far end and of a phone's LiDAR above.
  static constexpr double kNoise = 0.009;
  double square_ = 2 * kNoise * kNoise;  ///< metres², a mean over the latest frames
  double least_known_ = kNothingKnown;
};

}  // namespace plumbline
