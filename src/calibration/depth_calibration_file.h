// How a depth camera bends what it sees, as `plumbline calibrate` found it, in a TOML file.
#pragma once

#include <string>
#include <vector>

#include "plumbline/depth_distortion.h"

namespace plumbline {

/// `comments` are written at the top, a line each. Throws Error if the file cannot be written whole.
void write_depth_calibration(const std::string& path, const DepthDistortion& distortion,
                             const std::vector<std::string>& comments);

/// Throws Error with file and line for a file that is no TOML, lacks one of the values, or has one out of range.
DepthDistortion read_depth_calibration(const std::string& path);

}  // namespace plumbline
