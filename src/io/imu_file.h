// Raw readings of inertial sensors as text files.
#pragma once

#include <string>
#include <vector>

#include "core/inertial.h"

namespace plumbline {

/// Reads one reading a line, fields between blanks or commas, the stamp first, in seconds or whole nanoseconds. The
/// heading, or the last comment before the first line, names the columns: gyro_x, w_RS_S_x, gyr[rad/s] xyz, …;
/// accelerometer_x, a_RS_S_x, ax, …; magnetometer_x, mag[uT] xyz, …; with deg/s or g where the name says so. This
/// covers what `plumbline simulate` writes (imu.csv), EuRoC's imu0/data.csv, TUM's accelerometer.txt, and the BROAD
/// benchmark, whose reference orientations are kept where `movement` is 1. Without names: t a (4 fields), t ω a (7,
/// as EuRoC) or t ω a m (10). May be compressed with gzip.
///
/// Unsorted readings are sorted, of doubled stamps the first is kept, lines without a finite acceleration and a
/// half-written last line are left out; each is told in `notes` where that is given. Throws Error with file and line
/// for lines that are not of the form, and for a file without readings.
ImuRecording read_imu(const std::string& path, std::vector<std::string>* notes = nullptr);

/// Whether the file's columns are those of raw inertial readings without a quaternion.
bool is_imu_file(const std::string& path);

}  // namespace plumbline
