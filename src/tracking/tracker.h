// Where the camera is, frame by frame: predict, register (with or without the sensor, from several starts), retry where
// the result is doubtful, accept or reject.
#pragma once

#include <optional>
#include <vector>

#include "backend/backend.h"
#include "backend/maps.h"
#include "core/viewpoint.h"
#include "plumbline/frame.h"
#include "plumbline/parameters.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/tracking.h"
#include "tracking/live_frame.h"
#include "tracking/model_fit.h"
#include "tracking/motion_filter.h"
#include "tracking/motion_model.h"
#include "tracking/orientation_guide.h"
#include "tracking/registration.h"

namespace plumbline {

/// What a camera at `world_from_camera` sees of the model.
struct PredictedSurface {
  DepthPyramid levels;
  SE3 world_from_camera;
};

/// One frame as the tracker looks at it.
struct TrackerInput {
  const Frame& frame;             ///< its time and its sensor's reading
  const LiveFrame& live;          ///< its images
  const PredictedSurface& model;  ///< not looked at before a first frame was accepted
};

/// What is expected of a frame before its images are looked at.
struct Prediction {
  SE3 world_from_camera;  ///< where registration starts without a sensor
  kernels::Terms terms;   ///< what is known of the pose
  double redundancy = 1;  ///< how much less the images tell beside the terms, as successive frames err alike
};

/// What the tracker found for one frame, until it is accepted or rejected.
struct TrackedFrame {
  TrackingResult result;
  OrientationUse orientation = OrientationUse::off;
  SE3 world_from_seed;                     ///< where the registration started: the best of the starts
  int starts = 1;                          ///< that were tried
  double least_known = kNothingKnown;      ///< by the images, as `least_known` says
  bool was_compared = false;               ///< with a registration without the sensor
  std::optional<MotionFilter> inertial;    ///< by the sensor's readings at the frame's time, before the images
  std::optional<Eigen::Matrix3d> turn;     ///< since the previous frame, by the gyroscope
  bool is_after_interruption = false;      ///< nothing links it to the previous accepted frame
  bool is_recovered = false;               ///< its place was recognised among those that are known
  double travelled = 0;                    ///< of a recognised place, see core/viewpoint.h
  std::optional<Eigen::Matrix3d> witness;  ///< world_from_camera by which the sensor is judged, if there is one

  bool is_first() const { return result.status == TrackingStatus::initialised; }
  bool is_acceptable() const { return result.status != TrackingStatus::lost; }
};

/// All that one frame leaves for the next: a value, which can be copied, kept and set back.
struct TrackerState {
  SE3 world_from_camera;          ///< of the previous accepted frame
  Nanoseconds time = 0;           ///< of that frame
  double previous_agreement = 1;  ///< of that frame
  ModelFit fit = {};
  bool is_initialised = false;  ///< whether a frame has been accepted
  double travelled = 0;         ///< by the map's window, see core/viewpoint.h
  int probation = 0;            ///< frames that were also registered without the sensor
  MotionModel motion;
  SteadyTurn turn;
  OrientationGuide guide;
  MotionFilter steady, inertial;  ///< which never, and which always, takes the sensor's readings
  OrientationMonitor gyroscope;   ///< whether it turns as the images do
  Eigen::Matrix3d start_from_camera = Eigen::Matrix3d::Identity();  ///< by the gyroscope alone
};

class Tracker {
 public:
  /// `backend` must outlive the tracker. The first frame that is accepted has `world_from_camera`.
  Tracker(const Parameters& parameters, const SE3& world_from_camera, const Backend& backend,
          const OrientationSensor& sensor = {});

  /// Where the camera of a frame is, or why that is not known. The state stays as it is until `accept` or `reject`.
  /// `trace`: if given, gets every iteration of the registration that was taken.
  TrackedFrame track(const TrackerInput& input, std::vector<IcpIteration>* trace = nullptr) const;

  /// What the next frames are tracked from is this one.
  void accept(const Frame& frame, const TrackedFrame& tracked);
  /// The same for a frame whose place was recognised after an interruption: nothing is expected to go on from before.
  void resume(const Frame& frame, const TrackedFrame& recovered);
  /// The previous accepted frame remains what the next ones are tracked from.
  void reject(const TrackedFrame& tracked);

  const SE3& world_from_camera() const { return state_.world_from_camera; }  ///< of the previous accepted frame
  const TrackerState& state() const { return state_; }
  Viewpoint viewpoint() const { return {state_.world_from_camera, state_.travelled}; }
  void set_travelled(double travelled) { state_.travelled = travelled; }
  /// Goes on from a state of a tracker with the same parameters.
  void set_state(const TrackerState& state) { state_ = state; }

 private:
  /// A frame and what is expected of it.
  struct Task {
    const TrackerInput& input;
    const Prediction& expected;
  };

  bool has_readings(const Frame& frame) const;
  bool uses_filter(const Frame& frame) const;
  MotionFilter steady_at(const Frame& frame) const;
  MotionFilter inertial_at(const Frame& frame) const;
  Prediction predict(const Frame& frame) const;
  Prediction predict_filtered(const MotionFilter& filter, const Frame& frame) const;
  TrackedFrame register_filtered(const MotionFilter& filter, const TrackerInput& input,
                                 std::vector<IcpIteration>* trace) const;
  TrackedFrame register_inertial(const MotionFilter& filter, const TrackerInput& input,
                                 std::vector<IcpIteration>* trace) const;
  void correct_filters(const Frame& frame, const TrackedFrame& tracked);
  void judge_gyroscope(const TrackedFrame& tracked);
  TrackedFrame track_filtered(const TrackerInput& input, TrackedFrame found, std::vector<IcpIteration>* trace) const;
  TrackedFrame register_aided(const Task& task, std::vector<IcpIteration>* trace) const;
  TrackedFrame register_unaided(const Task& task, std::vector<IcpIteration>* trace) const;
  TrackedFrame retry_if_doubtful(TrackedFrame found, const Task& task, bool with_orientation,
                                 std::vector<IcpIteration>* trace) const;
  TrackedFrame better_of(TrackedFrame aided, TrackedFrame unaided) const;
  TrackingResult register_from(const SE3& seed, const Task& task, bool with_orientation,
                               const TrackingParameters& tracking, std::vector<IcpIteration>* trace) const;
  SE3 best_of(const std::vector<SE3>& starts, const Task& task, bool with_orientation) const;
  bool is_doubted(const TrackedFrame& found) const;
  double seconds_since_previous(const Frame& frame) const;

  TrackingParameters tracking_;
  OrientationParameters orientation_;
  MotionParameters motion_;
  const Backend* backend_;
  TrackerState state_;
};

}  // namespace plumbline
