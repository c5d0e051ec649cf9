// What an orientation sensor contributes to tracking: the seed, the term in the solve, and whether it is trusted.
//
// Frames: E earth (east, north, up), W world, C camera. Readings are earth_from_camera: mounting and time have been
// taken care of.
#pragma once

#include <deque>
#include <optional>
#include <string_view>
#include <vector>

#include "plumbline/angles.h"
#include "plumbline/orientation.h"
#include "plumbline/parameters.h"
#include "plumbline/se3.h"
#include "plumbline/tracking.h"
#include "tracking/terms.h"

namespace plumbline {

/// Whether the sensor predicts the camera's turns better than the guess that the camera does not turn. Judged over
/// spans of frames, where an orientation's smooth systematic error (docs/method.md §5) changes little, and a wrong
/// convention, mounting or clock much.
class OrientationMonitor {
 public:
  /// `floor`: radians, what tracker and a good sensor disagree by over a span.
  explicit OrientationMonitor(double distrust, double floor = kFloor) : distrust_(distrust), floor_(floor) {}
  void observe(const Eigen::Matrix3d& earth_from_camera, const Eigen::Matrix3d& world_from_camera);
  bool trusted() const { return trusted_; }

  static constexpr double kFloor = radians(1);

 private:
  struct Pair {
    Eigen::Matrix3d earth_from_camera, world_from_camera;
  };
  std::deque<Pair> history_;
  double missed_ = 0, turned_ = 0, count_ = 0;  ///< decaying sums: squared angles (radians²), spans
  double distrust_, floor_;
  bool trusted_ = true;
};

/// Whether any part of the registration asks for a sensor.
bool uses_sensor(const OrientationParameters& parameters);

class OrientationGuide {
 public:
  /// The headings of a sensor that has none, as an accelerometer, are used nowhere. Throws Error for a covariance that
  /// is none.
  explicit OrientationGuide(const OrientationParameters& parameters, const OrientationSensor& sensor = {});

  /// What a reading is good for now.
  OrientationUse use(const std::optional<Eigen::Matrix3d>& earth_from_camera) const;

  /// Initial guess of a frame: the position of `previous`, and the rotation that the parameters ask for (docs/method.md
  /// §2 and §6.3); `previous` itself for a sensor without heading. The reading must be usable (`use` says so).
  SE3 seed(const SE3& previous, const Eigen::Matrix3d& earth_from_camera) const;

  /// Initial guesses, `seed` first. A smooth systematic error of the heading (docs/method.md §5) grows with the turn
  /// since the previous reading, and may put the seed outside of what ICP converges from: so the others are turned
  /// about the vertical.
  std::vector<SE3> starts(const SE3& seed, const Eigen::Matrix3d& earth_from_camera) const;

  /// Adds the term that the parameters name, if they do.
  void add_term(const Eigen::Matrix3d& earth_from_camera, kernels::Terms* terms) const;

  /// An accepted pose, with the frame's reading if it has one. `witness` is the rotation to judge the sensor by:
  /// the pose's own, or one that was found without the sensor; none if nothing speaks for or against it.
  void observe(const SE3& world_from_camera, const std::optional<Eigen::Matrix3d>& earth_from_camera,
               const std::optional<Eigen::Matrix3d>& witness);

  bool is_on() const { return uses_sensor(parameters_); }
  bool is_judged() const { return parameters_.distrust > 0; }  ///< whether the sensor can lose trust

 private:
  void judge(const Eigen::Matrix3d& earth_from_camera, const Eigen::Matrix3d& world_from_camera);

  struct Reference {
    Eigen::Matrix3d world_from_camera, earth_from_camera;
  };
  OrientationParameters parameters_;
  OrientationSensor sensor_;
  OrientationMonitor monitor_;
  std::optional<Eigen::Matrix3d> earth_from_world_;
  std::optional<Reference> reference_;  ///< of the previous accepted frame
};

}  // namespace plumbline
