// From frames to trajectory and model: the whole of KinectFusion in the paper's order.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "plumbline/backend.h"
#include "plumbline/consistency.h"
#include "plumbline/export.h"
#include "plumbline/frame.h"
#include "plumbline/image.h"
#include "plumbline/map.h"
#include "plumbline/mesh.h"
#include "plumbline/orientation.h"
#include "plumbline/parameters.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/tracking.h"

namespace plumbline {

/// Wall time of the stages of one frame, milliseconds.
struct StageTimes {
  double preprocess = 0, track = 0, integrate = 0, raycast = 0;
  double total() const { return preprocess + track + integrate + raycast; }
};

/// What became of one frame.
struct FrameReport {
  int index = 0;
  Nanoseconds time = 0;
  TrackingResult tracking;             ///< status, reason, iterations, inliers, residuals
  SE3 world_from_camera;               ///< the estimate; for a lost frame the previous accepted pose
  bool is_after_interruption = false;  ///< nothing linked it to the previous accepted frame
  bool is_recovered = false;           ///< its place was recognised among those that are known
  OrientationUse orientation = OrientationUse::off;
  double sensor_lateness = 0;       ///< seconds by which the inertial sensor's stamps are late, as estimated so far
  int starts = 1;                   ///< poses that registration was begun from
  double seed_angle = 0;            ///< radians from the previous pose to the seed, the best of them
  double seed_to_result_angle = 0;  ///< radians from the seed to the estimate
  StageTimes milliseconds;
};

/// What `Pipeline::process` may be asked to keep of a frame. All stays empty for a frame that was not registered.
struct FrameDiagnostics {
  bool want_pixel_use = false, want_iterations = false;
  /// Why each pixel was or was not used at the finest tracked level, at the final estimate (`kernels::PixelUse`).
  Image<std::uint8_t> pixel_use;
  std::vector<IcpIteration> iterations;
};

/// One reconstruction. Not thread-safe; several may live side by side, each in its own thread, with a backend each.
class PLUMBLINE_EXPORT Pipeline {
 public:
  /// `backend` must outlive the pipeline. The world frame is the first camera's, unless `initial_pose`
  /// (world_from_camera of the first frame) says otherwise. `sensor`: the one whose readings the frames carry. Memory
  /// for the volume is allocated here, once. Throws Error for parameters that contradict each other and for a
  /// covariance that is none, std::bad_alloc if the volume does not fit.
  Pipeline(const Parameters& parameters, const Pinhole& camera, Backend& backend, const SE3& initial_pose = SE3(),
           bool with_color = false, const OrientationSensor& sensor = {});
  ~Pipeline();

  /// Tracks, fuses and predicts. Never throws for a frame that cannot be tracked: that is a status in the report, the
  /// frame is not fused and the model is kept. Throws Error if the frame's size is not the camera's, or if the volume
  /// is to be fitted to a first frame that has too few readings.
  FrameReport process(const Frame& frame, FrameDiagnostics* diagnostics = nullptr);

  /// The surface so far, world frame, metres.
  Mesh extract_mesh() const;

  /// The keyframes against the model as it is now. Without keyframes (`tracking.relocalise_after` = 0) nothing is
  /// compared. Costs a ray cast a keyframe, 200 keyframes at most.
  ModelConsistency check_consistency() const;

  /// The signed distances that it is the zero of: about 3 KiB for each brick with a surface.
  Map extract_map() const;

  /// Bricks of the map that changed since they were taken before, `max_bricks` at most: those that are new first,
  /// others after so many frames that their average can have moved. The first call counts all that is there. For
  /// whoever draws the map while it grows; about a microsecond a brick on the CPU.
  MapUpdate take_changes(int max_bricks);

  /// Of the latest frame that was accepted; before the first, the initial pose.
  SE3 world_from_camera() const;
  /// Pose and extent of the volume; the pose is set with the first frame.
  SE3 world_from_volume() const;
  double volume_side() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace plumbline
