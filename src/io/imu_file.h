// Raw readings of an inertial sensor as text files.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "plumbline/imu.h"

namespace plumbline {

/// Reads one sample a line, fields between commas or blanks; a gzipped file is unpacked on the way. What the columns
/// are is told by the heading, or by the last comment before the first line, where that names them (gyro_x, w_RS_S_x,
/// angular_velocity.x, acc_x, a_RS_S_x, ax, mag_x, …), else by their number:
///
///     timestamp,gyro_x,…,accelerometer_x,…,magnetometer_x,…   seconds; what `plumbline simulate` writes
///     #timestamp [ns],w_RS_S_x [rad s^-1],…,a_RS_S_z [m s^-2]  EuRoC's and TUM VI's imu0/data.csv
///     t,gx,gy,gz,ax,ay,az                                      FMDataset's imu file, milliseconds
///     # timestamp ax ay az                                     TUM RGB-D's accelerometer.txt, seconds
///     timestamp, a_x, …, alpha_x, …                            StrayScanner's imu.csv: a_x has the acceleration's sign
///     # BROAD … with 15 columns                                a trial of BROAD (Laidig et al. 2021) as csv, with its
///                                                              reference where the column `movement` is 1
///
/// Units in brackets, or behind a name as in gyro_x_dps, count (s, ms, us, ns; rad/s, deg/s; m/s^2, g; uT, mT, T, G).
/// Without them the readings decide: gravity is 9.8 m/s², 1 g, 1000 mg or 2048, 4096, 8192, 16384 counts; turn rates
/// are in deg/s where rad/s would be faster than a hand, or where gravity's direction turns so; three columns of
/// gravity are the accelerometer, whatever stands over them, if the others are not. What was concluded, `notes` tell.
/// The unit of the stamps follows from their interval: a sensor has 10 to 10000 readings a second.
///
/// Samples whose rate or force is not finite are left out with a note; a magnetic field that is not finite, or whose
/// fields are empty, is no reading. Unsorted samples are sorted, of doubled stamps the first is kept, a half-written
/// last line is left out; each is told in `notes` where that is given, as are readings that contradict each other.
/// Throws Error with file and line for lines that are not of the form, for a file without samples, for one without an
/// accelerometer, for unknown units, and where more than half of the samples are left out.
ImuRecording read_imu(const std::string& path, std::vector<std::string>* notes = nullptr);

/// Whether the columns, by their names, are those of raw readings with an accelerometer, and without an orientation.
/// Throws Error if the file cannot be read.
bool is_imu_file(const std::string& path);

/// body_from_camera of the depth camera that the file's format belongs to: the Kinect's with TUM's accelerometer.txt,
/// the phone's with StrayScanner's imu.csv. Empty for other files.
std::optional<Eigen::Matrix3d> mounting_by_format(const std::string& path);

/// Writes the first of these forms, with columns for the sensors that the recording has, so that samples read back to
/// nine digits; an empty magnetic field is three empty fields. Throws Error if the file cannot be written whole.
void write_imu(const std::string& path, const ImuRecording& recording);

}  // namespace plumbline
