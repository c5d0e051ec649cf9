// Trajectories as text files: plumbline/files.h, and the formats by name.
#pragma once

#include <string>
#include <vector>

#include "plumbline/files.h"
#include "plumbline/trajectory.h"

namespace plumbline {

/// Reads TUM's format: `t tx ty tz qx qy qz qw` a line, seconds and metres, world_from_camera, fields between blanks or
/// commas; a first line without any number names the columns. Unsorted poses are sorted, of doubled stamps the first is
/// kept, a half-written last line is left out; each is told in `notes` where that is given. Throws Error with file and
/// line for anything else that is not eight finite numbers with a quaternion of unit length (within 0.01; the rest is
/// normalised away), and for a file without poses.
Trajectory read_tum_trajectory(const std::string& path, std::vector<std::string>* notes = nullptr);

/// The poses of a 7-Scenes folder, `frame-000123.pose.txt` with a 4×4 world_from_camera each, at k/30 s as its frames.
/// Poses that are not finite are left out with a note. Throws Error for a matrix that is no rigid motion.
Trajectory read_seven_scenes_poses(const std::string& folder, std::vector<std::string>* notes = nullptr);

}  // namespace plumbline
