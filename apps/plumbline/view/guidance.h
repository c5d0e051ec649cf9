// What to tell whoever holds the camera.
#pragma once

#include <deque>
#include <string>
#include <vector>

#include "plumbline/pipeline.h"
#include "view/picture.h"

namespace plumbline::app {

/// The most urgent one comes first. `kind` is what the page draws by: "back", "confirm", "slower", "closer", "farther",
/// "little", "sensor", "disk", "full".
struct Hint {
  std::string kind, text, detail;
};

class Guide {
 public:
  /// `max_depth`: metres beyond which readings are not used.
  explicit Guide(double max_depth) : max_depth_(max_depth) {}

  /// Of the newest frame. `depth`: of its image, or of one shortly before.
  std::vector<Hint> advise(const FrameReport& report, const DepthStatistics& depth);

 private:
  struct Place {
    double seconds;
    SE3 world_from_camera;
  };
  void observe_motion(const FrameReport& report);
  void observe_hold(const TrackingResult& tracking);
  void advise_speed(double distance, std::vector<Hint>* hints) const;
  void advise_range(const DepthStatistics& depth, std::vector<Hint>* hints) const;

  double max_depth_;
  std::deque<Place> places_;  ///< of the latest quarter of a second
  double open_ = 0;           ///< smoothed share of frames that leave a direction open
};

}  // namespace plumbline::app
