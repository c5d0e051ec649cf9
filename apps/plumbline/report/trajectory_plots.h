// Figures of trajectories: the way seen from above, and the errors over time.
#pragma once

#include <string>
#include <vector>

#include "plumbline/evaluation.h"
#include "plumbline/trajectory.h"
#include "report/plot.h"

namespace plumbline::app {

/// One estimate and what came of it; all belong to one reference.
struct EvaluatedTrajectory {
  std::string name;
  const Trajectory* estimate = nullptr;
  const eval::AbsoluteError* error = nullptr;
};

/// Two axes of the world that lie in the picture, 0 = x … 2 = z.
struct ViewPlane {
  int right = 0, up = 1;
};

/// "xy", "xz", "yz", or "auto": those two along which the trajectory spreads most. Throws Error for anything else.
ViewPlane view_plane(const std::string& name, const Trajectory& trajectory);

/// Estimates, aligned, over the reference, as far as they were compared with it. A single one also has its differences
/// drawn, pose by pose, as the benchmark's tool does. Metres.
Panel trajectory_panel(const Trajectory& reference, const std::vector<EvaluatedTrajectory>& estimates, ViewPlane plane);
/// Distance of each pose from the reference after the alignment, over seconds since the reference's first stamp.
Panel absolute_error_panel(const Trajectory& reference, const std::vector<EvaluatedTrajectory>& estimates);
/// Both panels in one figure.
Plot absolute_error_plot(const Trajectory& reference, const std::vector<EvaluatedTrajectory>& estimates,
                         ViewPlane plane);

struct RelativeTrajectory {
  std::string name;
  const eval::RelativeError* error = nullptr;
};
/// Translation and rotation error of each pair over the time of its first pose in the reference.
Plot relative_error_plot(const Trajectory& reference, const std::vector<RelativeTrajectory>& estimates);

/// A path that nothing is known to compare with.
Plot path_plot(const std::string& name, const Trajectory& trajectory, ViewPlane plane);

}  // namespace plumbline::app
