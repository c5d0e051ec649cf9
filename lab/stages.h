// The stages of a frame, each ready to be run again and again on the same frame: what `plumbline bench`, the
// developers' benchmark and the count of instructions share.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "backend/maps.h"
#include "map/volume.h"
#include "plumbline/frame.h"
#include "plumbline/parameters.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "tracking/live_frame.h"
#include "tracking/registration.h"

namespace plumbline::app {

/// Frames held in memory, the last of which is measured after all others were fused.
struct StageFrames {
  Pinhole camera;
  std::vector<Frame> frames;
};

/// The analytic desk from `warm_up` + 1 poses of the default orbit. Throws Error if the size is not valid.
StageFrames simulated_frames(int width, int height, int warm_up);
/// The first frames of a sequence.
StageFrames recorded_frames(const std::string& folder, int warm_up);

/// One stage: it leaves the scene as it found it, but for the weights of voxels.
struct Stage {
  std::string name;
  std::function<void()> run;
  double items = 0;      ///< that it works on
  std::string item;      ///< "px" or "voxel"
  double bytes = 0;      ///< that have to be read and written if each is once
  bool is_whole = true;  ///< of the frame's way; else it is part of another stage
};

/// Wall time of one run, milliseconds: the median of as many as fit in `seconds`, at least three.
double median_milliseconds(const std::function<void()>& run, double seconds);
/// The same of what `time` says of each run.
double median_of(const std::function<double()>& time, double seconds);

/// A volume with a few frames in it, the prediction from the latest pose, and one more frame prepared.
class StageScene {
 public:
  /// The frames must outlive it.
  StageScene(const StageFrames& frames, const Parameters& parameters, const std::string& backend, int threads);
  StageScene(const StageScene&) = delete;
  StageScene& operator=(const StageScene&) = delete;

  /// In the order of a frame's way. They refer to this scene.
  std::vector<Stage> stages();
  /// A frame's way at once: nothing is waited for between its stages but what the next one needs.
  /// `stages` are this scene's.
  Stage frame(const std::vector<Stage>& stages);
  /// Median of one run, milliseconds: until all is done, and by the clock of the backend's device.
  double wall(const Stage& stage, double seconds) const;
  double device(const Stage& stage, double seconds) const;
  const Backend& backend() const { return *backend_; }

 private:
  TrackingResult register_live() const;
  void add_preprocessing(std::vector<Stage>& stages);
  void add_registration(std::vector<Stage>& stages);
  void add_mapping(std::vector<Stage>& stages);
  double pixels() const { return static_cast<double>(frames_.camera.width) * frames_.camera.height; }

  const StageFrames& frames_;
  Parameters parameters_;
  std::shared_ptr<Backend> backend_;
  LiveFrame live_;
  DepthPyramid model_;
  DepthLevel filtered_;  ///< what parts of the preprocessing write to
  Volume volume_;
  SE3 pose_;
};

}  // namespace plumbline::app
