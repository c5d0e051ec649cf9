#include "lab/angular_test.h"

#include <algorithm>

#include "backend/backend.h"
#include "plumbline/error.h"
#include "plumbline/frame.h"
#include "plumbline/pipeline.h"
#include "plumbline/se3.h"
#include "plumbline/statistics.h"
#include "plumbline/trajectory.h"

namespace plumbline::app {

AngleSummary summarise(const AngleResult& result) {
  AngleSummary summary;
  std::vector<double> translations, rotations;
  for (const PairOutcome& outcome : result.outcomes) {
    ++summary.pairs;
    summary.failures += !outcome.success;
    summary.lost += outcome.status == TrackingStatus::lost;
    summary.missing += outcome.orientation == OrientationUse::missing;
    if (!outcome.success) continue;
    translations.push_back(outcome.translation_error);
    rotations.push_back(outcome.rotation_error);
  }
  summary.median_translation = eval::statistics(translations).median;
  summary.median_rotation = eval::statistics(rotations).median;
  return summary;
}

AngularTest::AngularTest(const Sequence& sequence, const Parameters& parameters, Backend& backend,
                         const OrientationStream* orientation, const SuccessLimits& limits,
                         const OrientationSensor& sensor)
    : sequence_(sequence),
      parameters_(parameters),
      backend_(backend),
      orientation_(orientation),
      limits_(limits),
      sensor_(sensor) {}

AngleResult AngularTest::run(double degrees, const std::vector<eval::TurnedPair>& pairs,
                             const std::vector<std::optional<SE3>>& true_poses) const {
  AngleResult result{degrees, {}};
  for (const eval::TurnedPair& pair : pairs)
    result.outcomes.push_back(run_pair(pair, true_poses.at(pair.first)->inverse() * *true_poses.at(pair.second)));
  return result;
}

Frame AngularTest::read(std::size_t index) const {
  Frame frame = sequence_.read(static_cast<int>(index));
  if (orientation_ != nullptr) add_orientation(*orientation_, &frame);
  return frame;
}

/// A pipeline of its own: nothing that was seen before may help.
PairOutcome AngularTest::run_pair(const eval::TurnedPair& pair, const SE3& first_from_second) const {
  PairOutcome outcome;
  outcome.pair = pair;
  Pipeline pipeline(parameters_, sequence_.info().camera, backend_, SE3(), false, sensor_);
  const FrameReport first = pipeline.process(read(pair.first));
  if (first.tracking.status == TrackingStatus::lost) {
    outcome.reason = first.tracking.reason;
    return outcome;
  }
  const FrameReport second = pipeline.process(read(pair.second));
  outcome.status = second.tracking.status;
  outcome.reason = second.tracking.reason;
  if (orientation_ != nullptr)
    outcome.orientation = first.orientation == OrientationUse::missing ? first.orientation : second.orientation;
  if (outcome.status == TrackingStatus::lost) return outcome;
  const SE3 estimate = first.world_from_camera.inverse() * second.world_from_camera;
  const SE3 error = first_from_second.inverse() * estimate;
  outcome.translation_error = error.translation().norm();
  outcome.rotation_error = so3::angle(error.rotation());
  outcome.success = outcome.translation_error <= limits_.translation && outcome.rotation_error <= limits_.rotation;
  return outcome;
}

std::vector<std::optional<SE3>> true_poses(const Sequence& sequence, const Trajectory& truth, const std::string& path) {
  std::vector<std::optional<SE3>> poses;
  poses.reserve(static_cast<std::size_t>(sequence.size()));
  for (int i = 0; i < sequence.size(); ++i) poses.push_back(eval::pose_at(truth, sequence.time(i)));
  if (std::none_of(poses.begin(), poses.end(), [](const auto& pose) { return pose.has_value(); }))
    throw Error("no frame has a pose at its time", path, "Check that the trajectory belongs to this sequence.");
  return poses;
}

}  // namespace plumbline::app
