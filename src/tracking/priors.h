// What is known beside the depth image, as 6×6 terms: the second and third of H = H_icp/κσ² + H_orientation +
// H_translation.
#pragma once

#include <vector>

#include "core/parameters.h"
#include "core/se3.h"

namespace plumbline {

/// One 6×6 term on top of the registration's: 0.5 ξᵀ H ξ − bᵀ ξ, with ξ the left increment of world_from_camera.
struct NormalEquations {
  Matrix6d h = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
};

/// What an iteration's association found.
struct Association {
  int matched_pixels = 0, level_pixels = 1;
  double information = 1;  ///< what a pixel's squared residual weighs, see registration_information
};

/// Something known beside the depth image: evaluated afresh at the estimate of every iteration.
class Prior {
 public:
  virtual ~Prior() = default;
  virtual NormalEquations evaluate(const SE3& world_from_camera, const Association& found) const = 0;
};

/// Several at once.
class PriorSum final : public Prior {
 public:
  void add(const Prior* prior) { priors_.push_back(prior); }
  bool empty() const { return priors_.empty(); }
  NormalEquations evaluate(const SE3& world_from_camera, const Association& found) const override;

 private:
  std::vector<const Prior*> priors_;
};

/// What one pixel's squared residual weighs beside a prior, 1/κσ²: neighbouring pixels are not independent
/// (METHOD.md §6.4). κ is that of an image of 320×240; it goes with the number of pixels, so that an image tells the
/// same at every size.
double registration_information(const TrackingParameters& parameters, int level_pixels);

/// λ of the matched fraction ν in (0, 1] (METHOD.md §3); 0 for nothing matched.
double lambda(LambdaSchedule schedule, double c, double matched_fraction);

/// The published regulariser (METHOD.md §3): 2λn damps the rotation of each step, n the matched pixels;
/// on the scale of the registration's sums.
class RotationDamping final : public Prior {
 public:
  RotationDamping(LambdaSchedule schedule, double c) : schedule_(schedule), c_(c) {}
  NormalEquations evaluate(const SE3& world_from_camera, const Association& found) const override;

 private:
  LambdaSchedule schedule_;
  double c_;
};

/// The sensor's reading as a measurement (METHOD.md §6.4): residual log(R R_absᵀ) in earth axes with the sensor's own
/// covariance. However many steps are taken, the rotation is judged against the reading.
class OrientationAnchor final : public Prior {
 public:
  /// `covariance`: radians², earth axes, positive definite.
  OrientationAnchor(const Eigen::Matrix3d& earth_from_camera, const Eigen::Matrix3d& earth_from_world,
                    const Eigen::Matrix3d& covariance)
      : earth_from_camera_(earth_from_camera),
        earth_from_world_(earth_from_world),
        information_(covariance.inverse()) {}
  NormalEquations evaluate(const SE3& world_from_camera, const Association& found) const override;

 private:
  Eigen::Matrix3d earth_from_camera_, earth_from_world_, information_;
};

/// The tilt of a sensor without heading: residual z × u, u being where the estimate has what the sensor calls up. In
/// earth axes, radians for small tilts; about the vertical nothing is held (METHOD.md §6.4 with an infinite heading
/// variance). What heading the reading has does not matter.
class TiltAnchor final : public Prior {
 public:
  /// `covariance`: radians², earth axes; its horizontal part counts.
  TiltAnchor(const Eigen::Matrix3d& earth_from_camera, const Eigen::Matrix3d& earth_from_world,
             const Eigen::Matrix3d& covariance);
  NormalEquations evaluate(const SE3& world_from_camera, const Association& found) const override;

 private:
  Eigen::Vector3d up_in_camera_;
  Eigen::Matrix3d earth_from_world_;
  Eigen::Matrix3d information_ = Eigen::Matrix3d::Zero();
};

/// The covariance of the parameters, radians², earth axes (east, north, up).
Eigen::Matrix3d anchor_covariance(const OrientationParameters& parameters);

/// The camera is about where it is expected (METHOD.md §6.2): residual t − t_expected.
class TranslationPrior final : public Prior {
 public:
  /// `covariance`: metres², positive definite.
  TranslationPrior(const Eigen::Vector3d& expected, const Eigen::Matrix3d& covariance)
      : expected_(expected), information_(covariance.inverse()) {}
  NormalEquations evaluate(const SE3& world_from_camera, const Association& found) const override;

 private:
  Eigen::Vector3d expected_;
  Eigen::Matrix3d information_;
};

}  // namespace plumbline
