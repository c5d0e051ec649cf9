// The paper's angular test (Giancola, Schneider, Wonka, Ghanem 2018): a first frame defines the world, a second one,
// from which the camera is turned by a known angle, is registered to it. How often does that fail?
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "eval/turned_pairs.h"
#include "plumbline/angles.h"
#include "plumbline/frame.h"
#include "plumbline/orientation_stream.h"
#include "plumbline/parameters.h"
#include "plumbline/se3.h"
#include "plumbline/sequence.h"
#include "plumbline/trajectory.h"
#include "tracking/orientation_guide.h"
#include "tracking/registration.h"

namespace plumbline {
class Backend;
}

namespace plumbline::app {

/// What a registration may be off by at most to count as a success.
struct SuccessLimits {
  double translation = 0.02;     ///< metres
  double rotation = radians(1);  ///< radians
};

struct PairOutcome {
  eval::TurnedPair pair;
  /// Of the second frame; "lost" too if the first had no depth to begin with.
  TrackingStatus status = TrackingStatus::lost;
  LostReason reason = LostReason::none;
  OrientationUse orientation = OrientationUse::off;
  double translation_error = 0, rotation_error = 0;  ///< metres, radians; zero for a lost frame
  bool success = false;
};

struct AngleResult {
  double angle = 0;  ///< degrees, as asked for
  std::vector<PairOutcome> outcomes;
};

struct AngleSummary {
  int pairs = 0, failures = 0;
  int lost = 0;     ///< failures that the tracker knew of
  int missing = 0;  ///< pairs without a reading of the sensor that was given
  /// Of the successes; zero if there is none.
  double median_translation = 0, median_rotation = 0;  ///< metres, radians

  double failure_percent() const { return pairs > 0 ? 100.0 * failures / pairs : 0; }
};
AngleSummary summarise(const AngleResult& result);

class AngularTest {
 public:
  /// All must outlive the test; `orientation` may be null.
  AngularTest(const Sequence& sequence, const Parameters& parameters, Backend& backend,
              const OrientationStream* orientation, const SuccessLimits& limits, const OrientationSensor& sensor = {});

  /// true_poses[i] is that of frame i. Throws Error for a frame that cannot be read.
  AngleResult run(double degrees, const std::vector<eval::TurnedPair>& pairs,
                  const std::vector<std::optional<SE3>>& true_poses) const;

 private:
  Frame read(std::size_t index) const;
  PairOutcome run_pair(const eval::TurnedPair& pair, const SE3& first_from_second) const;

  const Sequence& sequence_;
  const Parameters& parameters_;
  Backend& backend_;
  const OrientationStream* orientation_;
  SuccessLimits limits_;
  OrientationSensor sensor_;
};

/// The true pose of each frame at its own time, empty where the trajectory has none. Throws Error if all are.
std::vector<std::optional<SE3>> true_poses(const Sequence& sequence, const Trajectory& truth, const std::string& path);

}  // namespace plumbline::app
