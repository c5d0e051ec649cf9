// Meshes, trajectories and sensors' readings as files.
#pragma once

#include <string>
#include <vector>

#include "plumbline/export.h"
#include "plumbline/imu.h"
#include "plumbline/mesh.h"
#include "plumbline/orientation.h"
#include "plumbline/trajectory.h"

namespace plumbline {

/// Writes by the name's ending, .ply, .obj, .stl or .glb. Throws Error for other endings, for normals or colours whose
/// number is not that of the positions, for an index beyond the vertices, and for a file that cannot be written whole.
PLUMBLINE_EXPORT void write_mesh(const std::string& path, const Mesh& mesh);

/// Reads by the name's ending, .ply or .obj. Polygons become fans of triangles, unknown properties and elements are
/// skipped, a point cloud is a mesh without triangles. Throws Error for a file that ends early, counts that its size
/// cannot hold, indices beyond the vertices, and malformed text.
PLUMBLINE_EXPORT Mesh read_mesh(const std::string& path);

/// What `SequenceInfo::groundtruth` names, or a user compares: a file in TUM's format; with other columns by its
/// heading (qw first, nanoseconds, EuRoC's csv, RTAB-Map's with ids); KITTI's and Replica's matrices; Redwood's .log; a
/// folder of 7-Scenes or ScanNet. Poses without stamps get those of their frames, which `notes` tell with what else was
/// concluded.
PLUMBLINE_EXPORT Trajectory read_trajectory(const std::string& path, std::vector<std::string>* notes = nullptr);

/// Writes TUM's format, `t tx ty tz qx qy qz qw` a line (seconds, metres, world_from_camera), so that poses read back
/// within 1e-8. Stamps have six decimals, or nine where that would
/// round one. Throws Error for a pose that is not finite and for a file that cannot be written whole.
PLUMBLINE_EXPORT void write_tum_trajectory(const std::string& path, const Trajectory& trajectory);

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
/// Gyroscope or accelerometer may be missing. Three columns without names are an accelerometer's if they can be
/// gravity. Throws Error with file and line for lines that are not of the form, for a file without samples, for one
/// without either sensor, for unknown units, and where more than half of the samples are left out.
PLUMBLINE_EXPORT ImuRecording read_imu(const std::string& path, std::vector<std::string>* notes = nullptr);

/// Writes the first of these forms, with columns for the sensors that the recording has, so that samples read back to
/// nine digits; an empty magnetic field is three empty fields. Throws Error if the file cannot be written whole.
PLUMBLINE_EXPORT void write_imu(const std::string& path, const ImuRecording& recording);

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
PLUMBLINE_EXPORT std::vector<OrientationSample> read_orientations(const std::string& path,
                                                                  const OrientationConvention& convention,
                                                                  std::vector<std::string>* notes = nullptr,
                                                                  OrientationConvention* used = nullptr);

/// Writes `t qx qy qz qw`, earth_from_body in east north up, stamps with nine decimals. `has_heading` as in
/// OrientationConvention. Throws Error if the file cannot be written whole.
PLUMBLINE_EXPORT void write_orientations(const std::string& path, const std::vector<OrientationSample>& samples,
                                         bool has_heading = true);

}  // namespace plumbline
