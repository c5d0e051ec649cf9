#include "view/guidance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "plumbline/angles.h"
#include "plumbline/time.h"

namespace plumbline::app {
namespace {

constexpr double kSpan = 0.25;                        ///< seconds that speeds are measured over
constexpr double kFastTurn = 55, kVeryFastTurn = 90;  ///< degrees a second
constexpr double kFastShift = 0.6;                    ///< of the distance to what is seen, a second
constexpr double kSlowTurn = 15, kSlowShift = 0.15;   ///< degrees, metres a second: slower than this smears nothing
constexpr double kBlurred = 0.7;                      ///< of the usual sharpness
constexpr std::size_t kSharpImages = 90, kBlurredImages = 3;
constexpr double kTooNear = 0.45;       ///< metres: depth cameras lose their readings below
constexpr double kFewReadings = 0.3;    ///< of the pixels
constexpr double kMaxCondition = 2000;  ///< of the registration's system: a direction is nearly open
constexpr double kMinInliers = 0.15;    ///< of the pixels with depth
constexpr std::uintmax_t kDiskNearlyFull = 1'000'000'000, kMegabyte = 1'000'000;
constexpr double kSmoothing = 0.15;  ///< weight of the newest frame

Hint lost_hint(const FrameReport& report) {
  if (report.tracking.status == TrackingStatus::provisional)
    return {"confirm", "Go on slowly", "This place seems known; other views of it decide."};
  const std::string reason(to_string(report.tracking.reason));
  if (report.tracking.reason == LostReason::no_depth)
    return {"back", "Turn back here", "The camera measures nothing: it is covered, too near or too far."};
  return {"back", "Turn back here", "Lost. Show the camera what it saw before, as in the image."};
}

}  // namespace

std::vector<Hint> standing_hints(std::optional<std::uintmax_t> free_bytes, const std::string& folder,
                                 const std::string& sensor) {
  std::vector<Hint> hints;
  if (free_bytes && *free_bytes < kDiskNearlyFull)
    hints.push_back(
        {"disk", "Disk nearly full", fmt::format("{} MB are left at {}.", *free_bytes / kMegabyte, folder)});
  if (sensor.starts_with("not connected"))
    hints.push_back({"sensor", "The sensor is silent", "It is " + sensor + "; the images go on without it."});
  else if (sensor.starts_with("not "))
    hints.push_back({"sensor", "Turn the sensor around", "It is " + sensor + "."});
  return hints;
}

std::vector<Hint> Guide::advise(const FrameReport& report, const DepthStatistics& depth) {
  std::vector<Hint> hints;
  if (!has_pose(report.tracking.status)) {
    places_.clear();
    open_ = 0;
    hints.push_back(lost_hint(report));
    return hints;
  }
  observe_motion(report);
  observe_hold(report.tracking);
  advise_speed(depth.median, &hints);
  if (open_ > 0.5)
    hints.push_back({"little", "Too little to hold on to",
                     "A bare surface fills the view. Bring edges and things into it as well."});
  advise_range(depth, &hints);
  return hints;
}

void Guide::observe_motion(const FrameReport& report) {
  const double now = to_seconds(report.time);
  places_.push_back({now, report.world_from_camera});
  while (places_.front().seconds < now - kSpan) places_.pop_front();
}

void Guide::observe_hold(const TrackingResult& tracking) {
  if (tracking.iterations.empty()) return;  // the first frame
  const bool is_open =
      tracking.rank < 6 || tracking.condition > kMaxCondition || tracking.inlier_fraction < kMinInliers;
  open_ += kSmoothing * ((is_open ? 1.0 : 0.0) - open_);
}

void Guide::observe_sharpness(double value) {
  sharpness_.push_back(value);
  if (sharpness_.size() > kSharpImages) sharpness_.pop_front();
}

/// Whether the latest images are all less sharp than those of the latest seconds usually are.
bool Guide::is_blurred() const {
  if (sharpness_.size() < 5 * kBlurredImages) return false;
  std::vector<double> sorted(sharpness_.begin(), sharpness_.end());
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return std::all_of(sharpness_.end() - kBlurredImages, sharpness_.end(),
                     [&](double value) { return value < kBlurred * *middle; });
}

void Guide::advise_speed(double distance, std::vector<Hint>* hints) const {
  const double seconds = places_.back().seconds - places_.front().seconds;
  if (seconds < 0.4 * kSpan) return;
  const SE3 &from = places_.front().world_from_camera, &to = places_.back().world_from_camera;
  const double turn = degrees(so3::angle(from.rotation().transpose() * to.rotation())) / seconds;
  const double shift = (to.translation() - from.translation()).norm() / seconds;
  if (turn > kFastTurn)
    hints->push_back({"slower", turn > kVeryFastTurn ? "Much slower" : "Slower",
                      fmt::format("The camera turns at {:.0f}° a second.", turn)});
  else if (shift > kFastShift * std::max(distance, 1.0))
    hints->push_back({"slower", "Slower", fmt::format("The camera moves at {:.1f} m a second.", shift)});
  else if ((turn > kSlowTurn || shift > kSlowShift) && is_blurred())
    hints->push_back({"slower", "Slower", "The images are blurred."});
}

void Guide::advise_range(const DepthStatistics& depth, std::vector<Hint>* hints) const {
  if (depth.median == 0) return;
  const bool is_sparse = depth.share < kFewReadings;
  if (depth.median < kTooNear || (is_sparse && depth.median < 2 * kTooNear))
    hints->push_back({"farther", "Farther away", fmt::format("Most of what is seen is {:.2f} m away.", depth.median)});
  else if (depth.median > 0.75 * max_depth_ || (is_sparse && depth.median > 2.5))
    hints->push_back({"closer", "Closer", fmt::format("Most of what is seen is {:.1f} m away.", depth.median)});
}

}  // namespace plumbline::app
