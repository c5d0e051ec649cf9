// Orientations as text files.
#pragma once

#include <string>
#include <vector>

#include "plumbline/orientation.h"

namespace plumbline {

/// Reads one orientation a line, fields between blanks or commas, and brings it to earth_from_body, east north up. What
/// the columns are is told by the last comment or heading before them where that names the quaternion's four (qx,
/// q_RS_w, orientation.x, …), else by their number:
///
///     t qx qy qz qw                        seconds; what `plumbline simulate` writes
///     t tx ty tz qx qy qz qw               seconds; TUM's format, so that a ground truth serves
///     t,qw,qx,qy,qz                        whole nanoseconds
///     t,px,py,pz,qw,qx,qy,qz[,…]           whole nanoseconds; EuRoC's state_groundtruth_estimate0 and vicon0
///
/// Angles named heading (or yaw), roll and pitch are read as well, and raw quaternions of the BNO055 (1/16384).
/// Stamps are nanoseconds where the heading says [ns] or a whole number is too great for seconds.
/// `convention.quaternion` overrides the order that the format suggests; `used`, where given, gets the convention with
/// the order that was read, and without heading if the comment says "tilt only".
///
/// Quaternions within 0.01 of unit length are normalised; others, and those that are not finite, are left out with a
/// note. Unsorted orientations are sorted, of doubled stamps the first is kept, a half-written last line is left out;
/// each is told in `notes` where that is given. Throws Error with file and line for lines that are not of the form, for
/// a file without orientations, and where more than half are left out.
std::vector<OrientationSample> read_orientations(const std::string& path, const OrientationConvention& convention,
                                                 std::vector<std::string>* notes = nullptr,
                                                 OrientationConvention* used = nullptr);

/// Writes `t qx qy qz qw`, earth_from_body in east north up, stamps with nine decimals. `has_heading` as in
/// OrientationConvention. Throws Error if the file cannot be written whole.
void write_orientations(const std::string& path, const std::vector<OrientationSample>& samples,
                        bool has_heading = true);

}  // namespace plumbline
