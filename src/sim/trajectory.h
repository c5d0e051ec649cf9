// Continuous camera motions: smooth in position and orientation, so that images and inertial readings agree.
//
// Every motion is a uniform cubic B-spline, cumulative on rotations (Kim, Kim, Shin 1995; Lovegrove, Patron-Perez,
// Sibley, "Spline fusion", BMVC 2013): twice continuously differentiable, as an accelerometer needs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "plumbline/se3.h"
#include "plumbline/trajectory.h"
#include "sim/scenes.h"

namespace plumbline::sim {

/// A path over 0 ≤ t ≤ duration, seconds; outside it stands still at its ends.
class Motion {
 public:
  /// `controls` are world_from_camera, `interval` seconds apart, the first at 0; the curve passes near them. Throws
  /// Error for fewer than 2 poses, one that is not finite, or an interval that is not positive.
  Motion(std::vector<SE3> controls, double interval);

  double duration() const { return duration_; }
  SE3 at(double seconds) const;
  /// Same path `factor` times as fast. Throws Error if the factor is not positive.
  Motion faster(double factor) const;
  /// Same path seen from another world: `placed_from_world` on the left.
  Motion placed(const SE3& placed_from_world) const;

 private:
  std::vector<SE3> controls_;
  double interval_, duration_;
};

/// What was lost on the way from recorded poses to a smooth motion.
struct Smoothing {
  double translation_rms = 0;  ///< metres between the recorded poses and the motion
  double rotation_rms = 0;     ///< radians
  double longest_gap = 0;      ///< seconds without a recorded pose; above 4 windows it is crossed on the straight way
};

/// A recorded path without the capture's jitter: local quadratic regression (Cleveland 1979) of positions and rotation
/// vectors over ±`window` seconds, or as many samples as it takes where the capture has gaps. Time 0 is the first pose.
/// Throws Error for fewer than 5 poses.
Motion smooth_motion(const Trajectory& recorded, double window = 0.06, Smoothing* lost = nullptr);

/// Motions around a scene's focus, all deterministic in their seed.
struct PathOptions {
  double duration = 8;  ///< seconds
  double radius = 0;    ///< metres, horizontally from the focus; 0 = chosen from the scene
  double height = 0;    ///< metres above the focus; 0 = chosen from the scene
  double span = 1.4;    ///< radians of the arc of `orbit`, metres of the line of `sweep` times two thirds
  double shake = 1;     ///< factor on the tremor of a hand: 4 mm and 0.3° rms, 0.4–4 Hz
  std::uint64_t seed = 1;
};

/// orbit: an arc around the focus to and fro. sweep: a line past it, looking ahead. handheld: a band-limited random
/// walk of eye and target before it, as one waves a camera about. turntable: once around at constant height and speed,
/// without tremor. dance: turned by some tens of degrees about all three axes in one place, as one calibrates a sensor.
/// walk: along the scene's way (without one, around the focus) at 0.8 m/s or, if `duration` is longer, slower, looking
/// ahead and about. Throws Error naming the known ones.
Motion make_path(const std::string& kind, const Scene& scene, const PathOptions& options);
std::vector<std::string> path_kinds();

/// What a camera turns about: its own vertical, to the left or to the right, or any axis across the line of sight.
/// A depth camera sees 57° across and 43° up and down, so of two views 50° apart the first kind has something in common
/// and the second often has nothing.
enum class TurnAxis { pan, any };

/// Pairs of views: at frame 2k the path's own view at that time, at frame 2k + 1 the same place turned by `angle`
/// radians about an axis drawn from the seed; then back. The paper's test of angular steps.
class TurnPairs {
 public:
  TurnPairs(Motion path, double angle, TurnAxis axis, double rate, std::uint64_t seed);
  SE3 at(double seconds) const;

 private:
  Eigen::Matrix3d turn(int pair) const;

  Motion path_;
  double angle_, rate_;
  TurnAxis axis_;
  std::uint64_t seed_;
};

/// Where a recorded path was put into a scene.
struct Placement {
  SE3 scene_from_recorded;    ///< a turn about the vertical and a move
  double clearance = 0;       ///< metres, smallest distance of the camera to a surface
  double share_in_range = 0;  ///< of the rays of all views that meet a surface between 0.5 and 4 m
  double share_on_focus = 0;  ///< of the rays that end within the scene's focus radius
};

/// The rigid placement that shows most of the scene: the vertical stays vertical, the path keeps at least `clearance`
/// metres from every surface and passes through none, and views are judged by rays. Searched on a grid, the same for
/// the same input. Throws Error if the path fits nowhere.
Placement place(const Motion& recorded, const Scene& scene, double clearance = 0.2);

/// The same figures for a given placement.
Placement judge(const Motion& recorded, const Scene& scene, const SE3& scene_from_recorded);

}  // namespace plumbline::sim
