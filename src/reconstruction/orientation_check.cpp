#include "reconstruction/orientation_check.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace plumbline {
namespace {

constexpr std::size_t kSpanFrames = 10;      // between the frames of a pair
constexpr std::size_t kFirstJudgement = 30;  // pairs; a second at 30 Hz
constexpr std::size_t kFinalJudgement = 300;

}  // namespace

std::optional<std::string> OrientationCheck::observe(const FrameReport& report, const OrientationReading& reading) {
  if (done_ || !has_pose(report.tracking.status)) return std::nullopt;
  if (reading.status != OrientationStatus::ok) return std::nullopt;
  recent_.push_back({report.world_from_camera.rotation(), reading.earth_from_body});
  if (recent_.size() <= kSpanFrames) return std::nullopt;
  const Tracked& then = recent_.front();
  pairs_.push_back({then.world_from_camera.transpose() * report.world_from_camera.rotation(), then.earth_from_body,
                    reading.earth_from_body});
  recent_.pop_front();
  if (pairs_.size() < kFirstJudgement || pairs_.size() % kFirstJudgement != 0) return std::nullopt;

  const ConventionCheck check = check_convention(pairs_, declared_.convention, declared_.body_from_camera);
  done_ = check.verdict != ConventionVerdict::too_little_motion || pairs_.size() >= kFinalJudgement;
  if (check.verdict == ConventionVerdict::another_fits || check.verdict == ConventionVerdict::none_fits)
    return check.message;
  return std::nullopt;
}

OrientationObserver::OrientationObserver(const std::optional<OrientationStreamOptions>& declared, Note note)
    : note_(std::move(note)) {
  // Turns of a sensor without heading cannot be compared with the camera's.
  if (declared && declared->convention.has_heading) check_.emplace(*declared);
}

void OrientationObserver::observe(const ProcessedFrame& processed) {
  const FrameReport& report = processed.report;
  lateness_ = report.sensor_lateness;
  const OrientationUse previous = previous_.value_or(report.orientation);
  previous_ = report.orientation;
  if (!processed.reading) return;
  if (const auto message = check_ ? check_->observe(report, *processed.reading) : std::nullopt) {
    message_ = *message;
    note_(*message);
  }
  const bool is_distrusted = report.orientation == OrientationUse::distrusted;
  if (is_distrusted != (previous == OrientationUse::distrusted))
    note_(fmt::format("frame {}: the orientation {}", report.index,
                      is_distrusted ? "disagrees with the tracking and is not used" : "agrees again"));
}

// A clock that is far off is found badly, and the result may be wrong although no frame is lost.
std::string OrientationObserver::message() const {
  constexpr double kUsual = 0.05;  // seconds
  if (!message_.empty() || std::abs(lateness_) <= kUsual) return message_;
  return fmt::format(
      "the inertial sensor's stamps seem to be {:.0f} ms {}: give --orientation-offset, which `plumbline calibrate` "
      "finds, or --orientation none",
      1e3 * std::abs(lateness_), lateness_ > 0 ? "late" : "early");
}

}  // namespace plumbline
