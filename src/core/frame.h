// What a sequence delivers.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/pinhole.h"
#include "core/se3.h"
#include "core/time.h"

namespace plumbline {

/// One depth frame, undistorted, with its colour image where the sequence has one.
struct Frame {
  int index = 0;              ///< position in the sequence, counted before --stride
  Nanoseconds time = 0;       ///< of the *depth* image
  DepthImage depth;           ///< raw readings, 0 = none
  double depth_scale = 5000;  ///< readings per metre
  ColorImage color;           ///< empty, or registered to the depth image (same size and intrinsics)
  /// Measured orientation of the camera at `time`, earth axes (x east, y north, z up); empty without a sensor.
  std::optional<Eigen::Matrix3d> earth_from_camera = {};
};

/// A reading of an orientation sensor: E earth (x east, y north, z up), B the sensor's body.
struct OrientationSample {
  Nanoseconds time = 0;
  Eigen::Matrix3d earth_from_body = Eigen::Matrix3d::Identity();
};

struct StampedPose {
  Nanoseconds time = 0;
  SE3 world_from_camera;
};
/// Ordered by time.
using Trajectory = std::vector<StampedPose>;

/// Indexed triangle mesh in metres, world frame. `normals` and `colors` are empty or one per vertex; triangles wind
/// counter-clockwise seen from outside (the free side).
struct Mesh {
  struct Float3 {
    float x, y, z;
  };
  struct Rgb {
    std::uint8_t r, g, b;
  };
  struct Triangle {
    std::uint32_t a, b, c;
  };
  std::vector<Float3> positions, normals;
  std::vector<Rgb> colors;
  std::vector<Triangle> triangles;
};

}  // namespace plumbline
