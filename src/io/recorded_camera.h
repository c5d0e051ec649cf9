// The camera as a recording's own files tell it.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "io/camera.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"

namespace plumbline {

/// The same camera, of images of width × height: pixel centres keep their place, c' = (c + ½)·s − ½. Empty if the
/// images are of another shape (beyond rounding to pixels), so that one was cut out of the other.
std::optional<Pinhole> scaled_to(const Pinhole& camera, int width, int height);

/// What a recording's files say of its depth camera.
struct RecordedCamera {
  CameraChoice choice;                                   ///< width and height 0 where they are not told
  double depth_scale = 0;                                ///< readings per metre; 0: not told
  std::optional<Pinhole> color = {};                     ///< of the colour images, where it is another
  std::optional<Eigen::Matrix3d> body_from_camera = {};  ///< of the inertial sensor
  SE3 color_from_depth = {};                             ///< where `color` is told, metres
};

/// The first of the files with intrinsics that are known by name, in the folder, in its folder `intrinsic`, or one
/// folder up: camera_intrinsic.json (Open3D), cam_params.json (Replica), intrinsic(s)_depth.txt, intrinsics.txt, K.txt,
/// camera.txt, calibration.txt (ETH3D), info.txt and _info.txt (BundleFusion, 12-Scenes, ScanNet), camera_matrix.csv,
/// transforms.json (nerfstudio), and the YAML files of ORB-SLAM, ROS, OpenCV and Kalibr. Empty without one. Files that
/// cannot be understood, and those that contradict the one taken, are warned of.
std::optional<RecordedCamera> find_recorded_camera(const std::string& folder, std::vector<Warning>* warnings);

/// A camera whose file tells no size of images, with the usual size whose centre is nearest to its principal point.
/// `shape`, if not 0, is width / height. Empty where none is near.
std::optional<Pinhole> sized_by_centre(Pinhole camera, double shape = 0);

/// The parsers of these, by content. Throw Error for anything else.
RecordedCamera read_json_camera(const std::string& path);
RecordedCamera read_info_camera(const std::string& path);  ///< `m_calibrationDepthIntrinsic = 16 numbers`, …
RecordedCamera read_text_camera(const std::string& path);  ///< 3×3, 4×4, or fx fy cx cy
RecordedCamera read_yaml_camera(
    const std::string& path);  ///< `Camera.fx: 525`, …; `camera_matrix: …`, `intrinsics: [4]`

/// Writes camera.json, which find_recorded_camera() reads: the depth camera, readings per metre, and how the inertial
/// sensor sits on it where that is known. Throws Error if the file cannot be written.
void write_camera_json(const std::string& folder, const Pinhole& camera, double depth_scale,
                       const std::optional<Eigen::Matrix3d>& body_from_camera = {});

/// fx 0 cx, 0 fy cy, 0 0 1 (or 4×4), numbers between blanks or commas, with or without brackets. Width and height stay
/// 0. Throws Error for other matrices.
Pinhole read_matrix_file(const std::string& path);

}  // namespace plumbline
