// Poses written as matrices.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "plumbline/se3.h"

namespace plumbline {

/// A row-major 4×4, or its upper three rows; empty if it is not finite. Throws Error, `path` being the file, for
/// another number of numbers and for what is no rigid motion.
std::optional<SE3> pose_of_matrix(const std::vector<double>& numbers, const std::string& path);

}  // namespace plumbline
