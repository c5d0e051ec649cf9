// How a sensor is mounted on a camera, from turns of both: rotation-only hand-eye calibration in closed form.
//
// Frames: B the sensor's body, C the camera. With M = body_from_camera, a turn of the camera a = log(first_from_second)
// is b = M a of the body.
#pragma once

#include <vector>

#include "plumbline/se3.h"

namespace plumbline {

/// Rotation vectors (radians) of the same turns of both sides, as many of one as of the other.
struct Turns {
  std::vector<Eigen::Vector3d> camera, body;
};

/// Angle rms between the turn of the camera and what the sensor makes of it, radians.
double turn_residual(const Turns& turns, const Eigen::Matrix3d& body_from_camera);

/// The rotation R with the largest trace(Rᵀ sum): the mean of rotations from their sum, the fit of vectors from Σ b aᵀ
/// (Kabsch 1976; Umeyama 1991). `mirrored` is the same among the reflections.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& sum, bool mirrored = false);

struct MountingFit {
  Eigen::Matrix3d proper, mirrored;
};

/// Σ ‖b − M a‖² minimal over the rotations, and over the reflections. Over the rotations it is the rotational part of
/// Park and Martin, "Robot sensor calibration: solving AX = XB on the Euclidean group", 1994, who take
/// M = (KᵀK)^(−1/2) Kᵀ with K = Σ a bᵀ; by singular values it stays a rotation for turns
/// that do not determine it. Without any turn it is the identity.
MountingFit fit_mounting(const Turns& turns);

/// The rotational part of Tsai and Lenz, "A new technique for fully autonomous and efficient 3D robotics hand/eye
/// calibration", 1989: linear least squares for modified Rodrigues parameters. Their form is singular for a mounting of
/// half a turn; it is therefore taken with the camera's axes renamed so that what remains is at most 120°. The
/// identity where the turns determine nothing.
Eigen::Matrix3d tsai_lenz(const Turns& turns);

}  // namespace plumbline
