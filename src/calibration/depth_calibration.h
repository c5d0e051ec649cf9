// A depth camera's own distortion from what it sees: two frames that saw one thing in different parts of the image must
// agree about it. No target, no sensor, no model: only a path that is roughly right.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "plumbline/calibration.h"
#include "plumbline/frame.h"
#include "plumbline/image.h"
#include "plumbline/parameters.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"
#include "tracking/live_frame.h"

namespace plumbline {

/// By how much a motion moves what is seen in the image, as an angle: radians, of a scene some metres away.
double view_change(const SE3& motion);

class DepthCalibration {
 public:
  /// The depth on which a path was tracked: as it was measured, or with the distortion that was found taken out.
  enum class Tracked { as_measured, undistorted };

  /// `backend` must outlive it. `frames`: how many there will be; about two hundred of them are kept.
  DepthCalibration(const Pinhole& camera, const PreprocessParameters& parameters, const Backend& backend, int frames);

  /// Frames in order of time, as they were measured.
  void add(const Frame& frame);
  /// What follows is not paired with what came before: its poses may be in another world.
  void begin_piece() { ++piece_; }

  /// Point-to-plane registration of pairs of frames, soon and long after each other, where beside the frames' poses one
  /// distortion of all of them is unknown (Gauss-Newton). The residual is one of inverse depth, so that a smaller world
  /// does not fit better. The path, world_from_camera, gives the poses to start from, and holds them where the pairs
  /// say little; `on` says how much. 0 threads takes all; the result is the same with any number. Nothing if too few
  /// frames overlap after the camera has moved.
  std::optional<DepthCalibrationResult> estimate(const Trajectory& path, Tracked on, int threads = 1) const;

  /// One frame on a coarse level of the pyramid: metres, and normals towards the camera.
  struct View {
    Nanoseconds time;
    int piece;
    Image<float> depth, normal_x, normal_y, normal_z;
  };

 private:
  Pinhole camera_;
  const Backend* backend_;
  int level_, stride_, seen_ = 0, piece_ = 0;
  LiveFrame live_;
  std::vector<View> views_;
};

}  // namespace plumbline
