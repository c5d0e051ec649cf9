// How a sensor is mounted on a camera and how its clock differs, from the camera's path and the sensor's readings, and
// whether the motion was such that this can be known.
//
// Frames: E earth, B the sensor's body, W the world of the camera's path, C the camera. The model of a frame at time t
// is
//
//     E_R_B(t − offset) = exp(e(Q)) Q,   Q = exp(x(t)) E_R_W · W_R_C(t) · (B_R_C)ᵀ
//
// with a slow drift x(t) between both (the tracker's, or of a heading without a magnetometer) and the sensor's
// systematic error e (`periodic_error`). That error is no detail: a heading that errs by ±10° over a turn stretches the
// turns about the vertical by up to a half, however short they are, so that turns alone mislead by degrees.
#pragma once

#include <string>

#include "plumbline/calibration.h"
#include "plumbline/orientation_stream.h"

namespace plumbline {

/// "x (nodding)" and the like: the nearest of the camera's axes, or the numbers where it is none of them.
std::string axis_text(const Eigen::Vector3d& axis);

}  // namespace plumbline
