// A whole run in one call: a sequence in, trajectory, map and mesh out, with all that `plumbline run` does beyond
// `Pipeline::process`.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "plumbline/calibration.h"
#include "plumbline/consistency.h"
#include "plumbline/export.h"
#include "plumbline/frame.h"
#include "plumbline/fusion.h"
#include "plumbline/imu_stream.h"
#include "plumbline/loops.h"
#include "plumbline/mesh.h"
#include "plumbline/orientation.h"
#include "plumbline/orientation_stream.h"
#include "plumbline/parameters.h"
#include "plumbline/pipeline.h"
#include "plumbline/se3.h"
#include "plumbline/sequence.h"
#include "plumbline/trajectory.h"

namespace plumbline {

/// How the readings of an orientation sensor are to be taken.
struct SensorOptions {
  OrientationStreamOptions stream;  ///< clock, gaps, mounting, convention of the file
  bool has_mounting = false;        ///< `stream.body_from_camera` is known; else the recording or the format may tell
  bool use_raw = true;              ///< give the raw readings to the tracker too, where there are some
  /// Applied to the orientations before they are used, to degrade an ideal sensor; none: they stay.
  std::function<std::vector<OrientationSample>(std::vector<OrientationSample>)> change = {};
};

/// Readings for the frames of a sequence.
struct SensorReadings {
  std::optional<OrientationStream> orientation;
  std::optional<ImuStream> inertial;  ///< gyroscope and accelerometer, where there are some
  OrientationSensor sensor;           ///< what is known of it
  std::string source;                 ///< in words
  std::string unused;                 ///< why a recording's own sensor is not used; empty if it is, or there is none
  std::vector<std::string> notes;     ///< what was concluded, a sentence each
};

/// Those of the recording's own sensor, filtered forward and backward, where it has a gyroscope, its mounting is known
/// and its stamps lie at frames; else `unused` says what is missing. Does not throw for readings that cannot be used.
PLUMBLINE_EXPORT SensorReadings recorded_sensor(const Sequence& sequence, const SensorOptions& options = {});

/// Those of a file (`read_orientations`, `read_imu`) or of another recording. Throws Error for a file that is none of
/// these.
PLUMBLINE_EXPORT SensorReadings read_sensor(const std::string& path, const SensorOptions& options = {});

/// Throws Error, with what would bring them together, if no reading lies at any frame.
PLUMBLINE_EXPORT void check_overlap(const OrientationStream& orientation, const Sequence& sequence,
                                    const std::string& path);

enum class LogLevel { note, warning };
/// Told a line of text while a call goes on, in the thread of that call. What it throws ends the call.
using Logger = std::function<void(LogLevel level, const std::string& line)>;

struct ReconstructOptions {
  Parameters parameters;
  std::string backend = "auto";  ///< as for `make_backend`
  int threads = 0;               ///< 0 = all cores; never changes a result
  std::vector<int> frames;       ///< of the sequence, ascending; empty: all
  SE3 initial_pose;              ///< world_from_camera of the first frame
  bool color = true;             ///< fuse colour where the sequence has it
  /// Of an orientation sensor. Without: the recording's own, as `recorded_sensor` gives it.
  std::optional<SensorReadings> sensor;
  /// Where the camera came back to what it had seen, the drift of its path is corrected before the final fusion, if the
  /// frames can be read again. `automatic`: if that pays, and not with parameters that recognise no places
  /// (`tracking.relocalise_after` of 0, as published methods have it).
  GlobalCorrection global = GlobalCorrection::automatic;
  bool mesh = true;                     ///< extract it at the end
  bool final_fusion = true;             ///< and fuse the accepted frames again along the final path, for a fine one
  FusionOptions fusion = {};            ///< of it; range of depth, colour and threads are filled in
  std::function<bool()> stopping = {};  ///< asked before each frame; true ends the run with what it has
  /// Told of each frame that was processed.
  std::function<void(const Frame& frame, const FrameReport& report)> on_frame = {};
  Logger log = {};  ///< none: nothing is told
};

/// What a run did.
struct Reconstruction {
  SequenceInfo sequence;
  Parameters parameters;
  std::string backend;                          ///< in words
  std::vector<FrameReport> frames;              ///< every frame that was processed; poses as in the trajectory
  Trajectory trajectory;                        ///< of the tracked frames, and of provisional ones since confirmed
  Trajectory live_trajectory;                   ///< as it was tracked, where it was corrected; else empty
  std::optional<LoopClosure> loops;             ///< what the correction found; none if it was not wanted
  Mesh mesh;                                    ///< empty if none was wanted
  std::optional<FusionResult> fusion;           ///< of the final fusion, without its mesh: that is `mesh`
  double fusion_seconds = 0;                    ///< that it took
  std::string fusion_note;                      ///< why the mesh is the volume's although a final fusion was wanted
  ModelConsistency consistency;                 ///< of the views with the final model
  SE3 world_from_volume;                        ///< of the volume's corner
  double volume_side = 0;                       ///< metres
  std::string orientation;                      ///< the sensor's source in words, or empty
  std::vector<std::string> orientation_notes;   ///< what was concluded about it
  std::string orientation_message;              ///< what the user should know about the readings, or empty
  std::optional<DepthCalibrationResult> depth;  ///< the distortion that this run found and took out
  std::string depth_refusal;                    ///< why none was found although it was looked for, a clause; or empty
  double depth_seconds = 0;                     ///< that looking for it took
  std::optional<ClockOffset> clock;             ///< of the sensor, where it was looked for; taken out if it is sure
  std::vector<std::string> skipped;             ///< why frames could not be read, a sentence each

  int tracked() const { return static_cast<int>(trajectory.size()); }
  int lost() const { return static_cast<int>(frames.size() - trajectory.size()); }
};

/// Finds the distortion of the depth and takes it out (`preprocess.calibrate_depth`), takes the recording's sensor,
/// tracks and fuses every frame, and extracts the mesh: the same to the bit as `plumbline run` on the same machine.
/// Losing track is a status of a frame; damaged frames are skipped and named. Throws Error for options that contradict
/// each other, a frame index out of range, a backend that is not available, and if most frames cannot be read;
/// std::bad_alloc if the volume does not fit. May be called from several threads at once.
PLUMBLINE_EXPORT Reconstruction reconstruct(const Sequence& sequence, const ReconstructOptions& options = {});

/// trajectory.txt (TUM's format), trajectory_live.txt if it was corrected, mesh.ply if there is a mesh, config.toml,
/// and depth.toml if a distortion was found, into a folder that is made. Throws Error if a file cannot be written
/// whole.
PLUMBLINE_EXPORT void write_reconstruction(const std::string& folder, const Reconstruction& run);

}  // namespace plumbline
