// The rigid motion that brings one set of points onto another.
#pragma once

#include "plumbline/se3.h"

namespace plumbline::eval {

/// target ≈ target_from_source * source with the least squares of the distances, without scale (Horn 1987, Umeyama
/// 1991). Columns are points in metres, as many in both and at least one; a set on a line or a point leaves a rotation
/// open, any of the best is returned.
SE3 rigid_alignment(const Eigen::Matrix3Xd& source, const Eigen::Matrix3Xd& target);

}  // namespace plumbline::eval
