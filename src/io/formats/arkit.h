// What recordings of Apple's ARKit have in common.
#pragma once

#include <Eigen/Core>

#include "plumbline/se3.h"

namespace plumbline {

/// world_from_camera of ARKit has the camera's x right, y up and z backward, as OpenGL's; ours has y down and z
/// forward.
inline SE3 camera_forward(const SE3& world_from_arkit_camera) {
  return world_from_arkit_camera *
         SE3(Eigen::Vector3d(1, -1, -1).asDiagonal().toDenseMatrix(), Eigen::Vector3d::Zero());
}

}  // namespace plumbline
