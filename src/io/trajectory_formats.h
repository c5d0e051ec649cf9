// Trajectories of other programs and benchmarks than TUM's, told apart by their headings and the form of their lines.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/text_file.h"
#include "plumbline/trajectory.h"

namespace plumbline {

/// Empty if the file is of no other format than TUM's. Throws Error for a file that is of one of these and malformed.
std::optional<Trajectory> read_other_trajectory(const TextFile& file, std::vector<std::string>* notes);

/// A folder of poses: 7-Scenes' or ScanNet's (pose/0.txt, a 4×4 each), or Replica's traj.txt. Throws Error for others.
Trajectory read_pose_folder(const std::string& folder, std::vector<std::string>* notes);

}  // namespace plumbline
