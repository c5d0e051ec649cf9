// Raw readings of an inertial sensor as text files: plumbline/files.h, and what they are told by.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "plumbline/files.h"
#include "plumbline/imu.h"

namespace plumbline {

/// Whether the columns, by their names, are those of raw readings, of a gyroscope or an accelerometer, and without an
/// orientation. Throws Error if the file cannot be read.
bool is_imu_file(const std::string& path);

/// Whether columns are named as a gyroscope's, whatever stands beside them. Throws Error if the file cannot be read.
bool has_gyroscope_columns(const std::string& path);

/// body_from_camera of the depth camera that the file's format belongs to: the Kinect's with TUM's accelerometer.txt,
/// the phone's with StrayScanner's imu.csv. Empty for other files.
std::optional<Eigen::Matrix3d> mounting_by_format(const std::string& path);

/// Readings of a recording that should be in m/s² and rad/s and are not: gravity and its turning tell g, counts, deg/s.
/// What was concluded is noted.
void settle_units(ImuRecording* recording, std::vector<std::string>* notes);

/// The file of a folder that holds the readings of an inertial sensor: imu.csv, accelerometer.txt, else the first whose
/// name says so and whose content is (imu.txt, imu_data.csv, gyro.csv, imu0/data.csv, …); empty without one.
std::string find_imu_file(const std::string& folder);

}  // namespace plumbline
