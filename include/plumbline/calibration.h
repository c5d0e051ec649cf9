// Calibration from recordings, without a target: the distortion of a camera's depth, and how an orientation sensor is
// mounted on the camera.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "plumbline/depth_distortion.h"
#include "plumbline/export.h"
#include "plumbline/orientation.h"
#include "plumbline/parameters.h"
#include "plumbline/sequence.h"
#include "plumbline/trajectory.h"

namespace plumbline {

class OrientationStream;

struct DepthCalibrationResult {
  DepthDistortion distortion;
  std::size_t pairs = 0;         ///< of frames, that were used
  double before = 0, after = 0;  ///< 1/m: rms of what they disagree by, outliers bounded
  Trajectory path;               ///< the given one, moved to where the pairs fit best
};

/// How far the tracking of a recording is.
struct CalibrationProgress {
  int pass = 0;  ///< over the frames, from 0
  int done = 0, total = 0, tracked = 0;
};

struct CalibrationOptions {
  Parameters parameters;
  std::string backend = "auto";
  int threads = 0;                                                   ///< 0 = all cores
  std::function<bool()> stopping = {};                               ///< asked before each frame
  std::function<void(const CalibrationProgress&)> on_progress = {};  ///< told after each frame
};

/// The distortion of a camera's depth from a recording of it: about two hundred of `frames`, in pieces, are tracked and
/// compared. Nothing if they tell too little, or agree as well without; `refusal`, where given, then gets why, as a
/// clause. Of `options.parameters` only the range of depth counts: the frames are tracked by preset `plumbline`,
/// quality `fast`. Throws Error for a frame that cannot be read, or once `options.stopping` returns true.
PLUMBLINE_EXPORT std::optional<DepthCalibrationResult> calibrate_depth(const Sequence& sequence,
                                                                       const std::vector<int>& frames,
                                                                       const CalibrationOptions& options = {},
                                                                       std::string* refusal = nullptr);

/// A camera's path through a recording, by the tracker from depth alone.
struct CameraPath {
  Trajectory poses;                                  ///< of the frames that were tracked, world_from_camera
  int frames = 0;                                    ///< that were processed
  std::optional<DepthCalibrationResult> depth = {};  ///< the distortion taken out; nothing if it could not be told
};

/// Which depth the path of a recording is tracked on.
enum class TrackedDepth {
  as_read,     ///< what the sequence gives
  undistorted  ///< its distortion is found by a first pass over the frames and taken out for a second
};

/// All of `frames` tracked with `options.parameters`, and the path adjusted by comparing frames that saw the same
/// things. Throws as `calibrate_depth` does.
PLUMBLINE_EXPORT CameraPath track_path(const Sequence& sequence, const std::vector<int>& frames, TrackedDepth depth,
                                       const CalibrationOptions& options = {});

/// For `SequenceOptions::depth_distortion` of the camera's other recordings: a TOML file. `comments` are written at the
/// top, a line each. Throws Error if the file cannot be written whole.
PLUMBLINE_EXPORT void write_depth_calibration(const std::string& path, const DepthDistortion& distortion,
                                              const std::vector<std::string>& comments);

/// What such a file says at its top of how it was made: by `command_line`, from so many pairs.
PLUMBLINE_EXPORT std::vector<std::string> depth_calibration_comments(const DepthCalibrationResult& found,
                                                                     const std::string& command_line);

/// Throws Error with file and line for a file that is no TOML, lacks one of the values, or has one out of range.
PLUMBLINE_EXPORT DepthDistortion read_depth_calibration(const std::string& path);

/// Offsets of an orientation sensor's clock that are searched.
struct OffsetSearch {
  double longest = 1;         ///< seconds: the largest offset either way
  double step = 0.005;        ///< seconds; a parabola finds the peak between two steps
  double window = 0.1;        ///< seconds over which a speed is measured, at least a frame
  double runner_up = 0.9;     ///< other peaks are told if they reach this part of the best
  std::size_t max_peaks = 3;  ///< that are told
};

/// How an orientation sensor's clock differs from the camera's, as far as a recording tells.
struct ClockOffset {
  bool is_sure = false;    ///< whether the turns of both leave no doubt
  double offset = 0;       ///< seconds, to be added to the sensor's stamps; 0 unless sure
  double sd = 0;           ///< seconds, of the offset where their turns fit best
  double correlation = 0;  ///< of the turn rates there, as vectors, −1…1
  double seconds = 0;      ///< that looking for it took
  std::string text;        ///< what was found, or why nothing is sure: a clause
};

/// From how the images and the sensor turn: frames in pieces of two seconds are tracked without the sensor, and the
/// turn rates compared as vectors in the camera's axes. `sensor` has its mounting and measures headings, or turns
/// alone. Offsets of up to a second are searched. Of `options.parameters` only the range of depth counts. Throws as
/// `calibrate_depth` does.
PLUMBLINE_EXPORT ClockOffset find_clock_offset(const Sequence& sequence, const std::vector<int>& frames,
                                               const OrientationStream& sensor, const CalibrationOptions& options = {});

struct MountingOptions {
  OffsetSearch search;
  /// What may remain unknown (standard deviations) before the motion counts as too poor: radians, seconds.
  double worst_mounting = 0.005;
  double worst_offset = 0.003;
};

/// Of the first that applies; in the order of the list.
enum class MotionVerdict {
  good,
  too_short,        ///< too few frames with a reading
  no_rotation,      ///< the camera hardly turned
  one_axis,         ///< it turned about one axis only
  does_not_fit,     ///< the sensor does not turn as the camera does: another recording, another convention
  mounting_unsure,  ///< rotation about two axes, but not enough of it for this sensor
  offset_unsure     ///< too slow to tell the time
};
PLUMBLINE_EXPORT std::string_view to_string(MotionVerdict verdict);

struct PLUMBLINE_EXPORT MountingCalibration {
  MotionVerdict verdict = MotionVerdict::too_short;
  std::string advice;  ///< what to do, in words; empty if the verdict is good

  Eigen::Matrix3d body_from_camera = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< radians², rotation about the camera's axes x, y, z
  double time_offset = 0;                                ///< seconds, to be added to the sensor's stamps
  double time_offset_sd = 0;                             ///< seconds

  Eigen::Matrix3d tsai_lenz = Eigen::Matrix3d::Identity(), park_martin = Eigen::Matrix3d::Identity();
  double tsai_lenz_residual = 0, park_martin_residual = 0;  ///< radians rms over `turns` turns
  std::size_t turns = 0;
  double first_offset = 0, correlation = 0;  ///< of the angular speeds: seconds, and how well they agree

  std::size_t frames = 0;                                ///< with a reading, used for the refinement
  double duration = 0;                                   ///< seconds from the first to the last of them
  double residual = 0;                                   ///< radians rms of a frame after the refinement
  double redundancy = 1;                                 ///< successive residuals that tell no more than one
  double drift = 0;                                      ///< radians from the smallest to the largest x(t)
  Eigen::Vector3d systematic = Eigen::Vector3d::Zero();  ///< radians: largest error found about east, north, up
  Eigen::Vector3d spread =
      Eigen::Vector3d::Zero();  ///< radians rms of the turning about its principal axes, descending
  Eigen::Matrix3d spread_axes = Eigen::Matrix3d::Identity();  ///< those axes in the camera's frame, as columns
  double speed = 0;                                           ///< rad/s rms

  /// Standard deviations of the mounting along the eigenvectors of its information, radians, ascending.
  Eigen::Vector3d sd_along() const;
  /// The camera's axis about which the mounting is known worst.
  Eigen::Vector3d worst_axis() const;
};

/// `camera` is world_from_camera, ordered by time; `sensor` has neither mounting nor time offset. Closed forms from
/// turns of some degrees, then everything at once by Levenberg-Marquardt with a robust loss (Ceres), where the scales
/// of noise, drift and systematic error follow from the data (evidence approximation: MacKay, "Bayesian interpolation",
/// 1992). The standard deviations count correlated residuals once, and contain what drift and systematic error leave
/// open. Throws Error if the two do not overlap in time at any offset searched.
PLUMBLINE_EXPORT MountingCalibration calibrate_mounting(const Trajectory& camera, const OrientationStream& sensor,
                                                        const MountingOptions& options = {});

/// The same from the sensor's samples, ordered by time: earth_from_body on the sensor's own clock. Throws Error also if
/// they are not so.
PLUMBLINE_EXPORT MountingCalibration calibrate_mounting(const Trajectory& camera,
                                                        const std::vector<OrientationSample>& samples,
                                                        const MountingOptions& options = {});

}  // namespace plumbline
