// Sequences of depth (and colour) frames on disk, whatever their layout, as one thing to read from.
//
// The layouts are those of docs/formats.md: data sets' folders, what scanning apps and cameras' recorders write, plain
// folders of depth images, and recordings in one file.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "plumbline/depth_distortion.h"
#include "plumbline/export.h"
#include "plumbline/frame.h"
#include "plumbline/imu.h"
#include "plumbline/pinhole.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"

namespace plumbline {

/// What the user said about a sequence; what is left empty is found out.
struct SequenceOptions {
  std::optional<Pinhole> intrinsics;     ///< width and height may be 0: taken from the images
  std::string camera;                    ///< or a camera by name, one of `camera_names()`
  std::optional<Distortion> distortion;  ///< in place of the camera's own
  bool undistort = true;                 ///< take the distortion out of the frames
  std::optional<double> depth_scale;     ///< readings per metre; empty = the format's own
  bool color = true;                     ///< read colour where there is some
  double max_time_difference = 0.02;     ///< s, between a depth image and its colour image
  std::string depth_topic, color_topic;  ///< of a ROS bag; empty: those that fit best
  DepthDistortion depth_distortion;      ///< taken out of the depth; empty: none
  int min_confidence = 1;  ///< readings whose confidence image has less are left out; 1: those of the lowest level, 0
  bool strict = false;     ///< a warning is an error
};

/// Something in a recording that does not add up, although it can be read.
struct Warning {
  std::string what;        ///< one sentence, with the figures
  std::string what_to_do;  ///< one sentence
};

/// What was found, in values and in words for the user.
struct SequenceInfo {
  std::string path;           ///< as given
  std::string format;         ///< "TUM RGB-D", "StrayScanner", "depth images", "ROS bag", …: see docs/formats.md
  Pinhole camera;             ///< of the frames that read() gives
  Distortion distortion;      ///< of the images on disk; gone from the frames if options.undistort
  double depth_scale = 0;     ///< readings per metre
  std::string camera_source;  ///< where the camera comes from
  std::string depth_scale_source;
  bool camera_is_guess = false;       ///< neither given nor told by the recording
  bool depth_scale_is_guess = false;  ///< the same
  int frames = 0;                     ///< depth frames
  int color_frames = 0;               ///< those of them that have colour
  Nanoseconds first_time = 0, last_time = 0;
  std::string groundtruth;                               ///< where Sequence::read_groundtruth() reads it, or empty
  std::optional<Eigen::Matrix3d> body_from_camera = {};  ///< of the recording's IMU, by its calibration
  std::vector<std::string> notes;                        ///< what the user should know, a sentence each
  std::vector<Warning> warnings = {};                    ///< what does not add up
};

/// Frames in order of time. All members may be called from several threads at once.
class PLUMBLINE_EXPORT Sequence {
 public:
  virtual ~Sequence() = default;
  Sequence(const Sequence&) = delete;
  Sequence& operator=(const Sequence&) = delete;

  const SequenceInfo& info() const { return info_; }
  int size() const { return static_cast<int>(times_.size()); }
  /// Of the depth image of frame i, 0 ≤ i < size().
  Nanoseconds time(int i) const { return times_.at(static_cast<std::size_t>(i)); }

  /// Reads and undistorts one frame. Throws Error naming the file if it is damaged, of the wrong kind, or of another
  /// size than the first; other frames can be read after that.
  virtual Frame read(int index) const = 0;

  /// The inertial sensor's raw readings, on the frames' clock: of the recording, or of imu.csv or accelerometer.txt in
  /// the folder; without samples where there is none. Throws Error if they cannot be read.
  virtual ImuRecording read_imu(std::vector<std::string>* notes = nullptr) const = 0;

  /// The true poses, world_from_camera, on the frames' clock; empty where info().groundtruth is. Throws Error if they
  /// cannot be read.
  virtual Trajectory read_groundtruth(std::vector<std::string>* notes = nullptr) const;

 protected:
  /// `times` in ascending order; frames and times of `info` follow from it.
  Sequence(SequenceInfo info, std::vector<Nanoseconds> times);

 private:
  friend std::unique_ptr<Sequence> open_sequence(const std::string& path, const SequenceOptions& options);

  SequenceInfo info_;
  std::vector<Nanoseconds> times_;
};

/// Finds out the layout of the folder or file at `path`, its frames and its camera, and checks the first images. Throws
/// Error if there is no such folder or file, it holds no frames, a list is malformed, the camera is unknown or does not
/// fit the images, and with `strict` if there is a warning.
PLUMBLINE_EXPORT std::unique_ptr<Sequence> open_sequence(const std::string& path, const SequenceOptions& options = {});

/// The same sequence with that distortion taken out of its depth, which its notes then say. Throws Error for images of
/// another size.
PLUMBLINE_EXPORT std::unique_ptr<Sequence> without_depth_distortion(std::unique_ptr<Sequence> measured,
                                                                    DepthDistortion distortion);

/// The names that SequenceOptions::camera takes.
PLUMBLINE_EXPORT std::vector<std::string> camera_names();

}  // namespace plumbline
