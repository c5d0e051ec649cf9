// The part of the surface that is kept.
#pragma once

#include <Eigen/Core>

#include "plumbline/mesh.h"
#include "plumbline/se3.h"

namespace plumbline::app {

struct CropBox {
  SE3 world_from_box;                              ///< its middle
  Eigen::Vector3d half = Eigen::Vector3d::Zero();  ///< of its sides, metres

  bool contains(const Eigen::Vector3d& world) const {
    return ((world_from_box.inverse() * world).cwiseAbs().array() <= half.array()).all();
  }
};

/// The triangles with all corners in the box.
Mesh cropped(const Mesh& mesh, const CropBox& box);

}  // namespace plumbline::app
