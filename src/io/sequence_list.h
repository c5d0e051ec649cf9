// The files of a sequence's frames, found in each of the layouts.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "io/camera.h"
#include "plumbline/imu.h"
#include "plumbline/se3.h"
#include "plumbline/sequence.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"

namespace plumbline {

struct SequenceEntry {
  Nanoseconds time = 0;           ///< of the depth image
  std::string depth, color = {};  ///< paths; color may be empty
  std::string confidence = {};    ///< path of an image of the depth's shape, or empty
  /// The frame's, where they differ, of the size of `SequenceList::camera`: the images are brought to that one.
  std::optional<Pinhole> camera = {};
};

struct SequenceList {
  std::string folder;  ///< that holds the frames
  std::string format;
  std::vector<SequenceEntry> entries;  ///< by time, at least one, depth files exist
  std::string groundtruth;
  std::function<Trajectory(std::vector<std::string>* notes)> read_truth;  ///< poses that are no file of their own form
  std::optional<CameraChoice> camera;  ///< that came with the frames, of any size: scaled to the depth's
  std::string camera_refusal = {};     ///< where there is none: what is wrong with the file that should tell it
  /// Of the colour images, of any size or none (then of theirs); empty: the depth's own.
  std::optional<Pinhole> color_camera;
  SE3 color_from_depth;       ///< of that camera, metres
  std::string format_camera;  ///< see CameraClues
  bool format_camera_is_guess = false;
  double depth_scale = 0;  ///< the format's own
  std::string depth_scale_source;
  bool depth_scale_is_guess = false;
  /// The reading that each of the 65536 values in the files means, of `depth_scale` a metre; empty: they mean
  /// themselves.
  std::vector<std::uint16_t> reading_of = {};
  bool stamps_are_frame_numbers = false;            ///< one second a frame says nothing about gaps
  std::optional<Eigen::Matrix3d> body_from_camera;  ///< of the IMU whose readings lie beside the frames
  /// Readings that are no file imu.csv or accelerometer.txt; empty: these.
  std::function<ImuRecording(std::vector<std::string>* notes)> read_imu;
  std::vector<std::string> notes;
  std::vector<Warning> warnings;
};

/// Throws Error if the folder is none of the layouts, or holds no frames.
SequenceList list_sequence(const std::string& path, const SequenceOptions& options);

}  // namespace plumbline
