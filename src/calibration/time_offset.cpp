#include "calibration/time_offset.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/median.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"

namespace plumbline {
namespace {

constexpr std::size_t kMinSpeeds = 10;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Seconds after the origin (stamps of 10⁹ s leave a double a quarter of a microsecond), and rad/s.
struct Speed {
  double time, value;
};

/// Each frame against the first one at least a window later; gaps are left out.
std::vector<Speed> camera_speeds(const Trajectory& camera, Nanoseconds origin, double window) {
  std::vector<Speed> speeds;
  for (std::size_t i = 0, j = 0; i < camera.size(); ++i) {
    while (j < camera.size() && to_seconds(camera[j].time - camera[i].time) < 0.999 * window) ++j;
    if (j == camera.size()) break;
    const double span = to_seconds(camera[j].time - camera[i].time);
    if (span > 2 * window) continue;
    const SE3 turn = camera[i].world_from_camera.inverse() * camera[j].world_from_camera;
    speeds.push_back({to_seconds(camera[i].time - origin) + span / 2, so3::angle(turn.rotation()) / span});
  }
  return speeds;
}

/// On a grid that begins at `begin` seconds; NaN where the sensor has a gap.
std::vector<double> sensor_speeds(const OrientationStream& sensor, Nanoseconds origin, double begin, double end,
                                  double step, double window) {
  std::vector<double> speeds;
  const auto count = static_cast<std::size_t>(std::max(0.0, std::ceil((end - begin) / step))) + 1;
  for (std::size_t i = 0; i < count; ++i) {
    const double middle = begin + static_cast<double>(i) * step;
    const OrientationReading a = sensor.lookup(origin + from_seconds(middle - window / 2)),
                             b = sensor.lookup(origin + from_seconds(middle + window / 2));
    const bool both = a.status == OrientationStatus::ok && b.status == OrientationStatus::ok;
    speeds.push_back(both ? so3::angle(a.earth_from_body.transpose() * b.earth_from_body) / window : kNone);
  }
  return speeds;
}

/// Pearson's correlation of camera.value with the grid at camera.time − offset; NaN if they share too little.
double correlation(const std::vector<Speed>& camera, const std::vector<double>& grid, double begin, double step,
                   double offset) {
  double n = 0, sx = 0, sy = 0, sxx = 0, syy = 0, sxy = 0;
  for (const Speed& speed : camera) {
    const double position = (speed.time - offset - begin) / step;
    if (!(position >= 0) || position + 1 >= static_cast<double>(grid.size())) continue;
    const auto i = static_cast<std::size_t>(position);
    const double share = position - static_cast<double>(i), y = (1 - share) * grid[i] + share * grid[i + 1];
    if (std::isnan(y)) continue;
    const double x = speed.value;
    n += 1, sx += x, sy += y, sxx += x * x, syy += y * y, sxy += x * y;
  }
  if (n < static_cast<double>(kMinSpeeds) || 2 * n < static_cast<double>(camera.size())) return kNone;
  const double vx = sxx - sx * sx / n, vy = syy - sy * sy / n;
  if (!(vx > 1e-12 * n) || !(vy > 1e-12 * n)) return kNone;
  return (sxy - sx * sy / n) / std::sqrt(vx * vy);
}

std::vector<OffsetCandidate> peaks(const std::vector<double>& values, const OffsetSearch& search) {
  std::vector<OffsetCandidate> found;
  for (std::size_t i = 1; i + 1 < values.size(); ++i) {
    const double a = values[i - 1], b = values[i], c = values[i + 1];
    if (!(b > a) || !(b >= c) || !(b > 0)) continue;  // false for NaN, too
    const double shift = 0.5 * (a - c) / (a - 2 * b + c);
    found.push_back({-search.longest + (static_cast<double>(i) + shift) * search.step, b - 0.25 * (a - c) * shift});
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.correlation > b.correlation; });
  while (!found.empty() &&
         (found.size() > search.max_peaks || found.back().correlation < search.runner_up * found.front().correlation))
    found.pop_back();
  return found;
}

}  // namespace

std::vector<OffsetCandidate> correlate_angular_speed(const Trajectory& camera, const OrientationStream& sensor,
                                                     const OffsetSearch& search) {
  if (camera.size() < kMinSpeeds) return {};
  std::vector<double> intervals;
  for (std::size_t i = 1; i < camera.size(); ++i) intervals.push_back(to_seconds(camera[i].time - camera[i - 1].time));
  const double window = std::max(search.window, median(intervals));
  const Nanoseconds origin = camera.front().time;
  const std::vector<Speed> speeds = camera_speeds(camera, origin, window);
  if (speeds.size() < kMinSpeeds) return {};
  const double begin = speeds.front().time - search.longest - search.step,
               end = speeds.back().time + search.longest + search.step;
  const std::vector<double> grid = sensor_speeds(sensor, origin, begin, end, search.step, window);
  std::vector<double> values;
  const int steps = static_cast<int>(std::ceil(2 * search.longest / search.step));
  for (int i = 0; i <= steps; ++i)
    values.push_back(correlation(speeds, grid, begin, search.step, -search.longest + i * search.step));
  return peaks(values, search);
}

}  // namespace plumbline
