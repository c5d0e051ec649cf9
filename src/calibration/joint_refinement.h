// Mounting, time offset, drift and systematic error of an orientation sensor at once. The model stands in
// imu/mounting_calibration.h; this is its least-squares problem.
#pragma once

#include <vector>

#include "plumbline/orientation_stream.h"
#include "plumbline/trajectory.h"

namespace plumbline {

struct JointEstimate {
  Eigen::Matrix3d body_from_camera = Eigen::Matrix3d::Identity();
  double time_offset = 0;                                // seconds
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of the mounting, radians², body axes
  double time_offset_sd = 0;                             // seconds
  double residual = 0;                                   // radians rms of a frame
  double redundancy = 1;                                 // successive residuals that tell no more than one
  double drift = 0;                                      // radians from the smallest to the largest drift
  Eigen::Vector3d systematic = Eigen::Vector3d::Zero();  // radians, largest error over the frames' orientations
};

/// From a mounting and an offset near the solution. `camera` are the frames to use, all of which should have a reading
/// at the offset given.
JointEstimate refine_jointly(const Trajectory& camera, const OrientationStream& sensor,
                             const Eigen::Matrix3d& body_from_camera, double time_offset);

}  // namespace plumbline
