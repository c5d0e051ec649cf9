// What to tell whoever holds the camera.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
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

/// What holds for longer than a frame: the disk is nearly full, the sensor is not ready. `free_bytes` of the disk that
/// `folder` lies on, if that is known; a sensor that is not ready has words that begin with "not".
std::vector<Hint> standing_hints(std::optional<std::uintmax_t> free_bytes, const std::string& folder,
                                 const std::string& sensor);

class Guide {
 public:
  /// `max_depth`: metres beyond which readings are not used.
  explicit Guide(double max_depth) : max_depth_(max_depth) {}

  /// Of the newest frame. `depth`: of its image, or of one shortly before.
  std::vector<Hint> advise(const FrameReport& report, const DepthStatistics& depth);
  /// Of the newest colour image, see `sharpness`. Without any, blur is not spoken of.
  void observe_sharpness(double value);

 private:
  struct Place {
    double seconds;
    SE3 world_from_camera;
  };
  void observe_motion(const FrameReport& report);
  void observe_hold(const TrackingResult& tracking);
  bool is_blurred() const;
  void advise_speed(double distance, std::vector<Hint>* hints) const;
  void advise_range(const DepthStatistics& depth, std::vector<Hint>* hints) const;

  double max_depth_;
  std::deque<Place> places_;      ///< of the latest quarter of a second
  std::deque<double> sharpness_;  ///< of the latest images
  double open_ = 0;               ///< smoothed share of frames that leave a direction open
};

}  // namespace plumbline::app
