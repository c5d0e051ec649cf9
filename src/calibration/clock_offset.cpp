// `find_clock_offset`: how fast the images and the sensor turn, compared at every offset.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "calibration/camera_path.h"
#include "core/median.h"
#include "plumbline/angles.h"
#include "plumbline/calibration.h"
#include "plumbline/orientation_stream.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"

namespace plumbline {
namespace {

using Eigen::Vector3d;

constexpr int kClockPieces = 4;
constexpr double kPieceSeconds = 2;
constexpr double kMinFrameInterval = 0.025;  // seconds: more frames a second tell no more

// What makes an offset sure: the rates vary enough, agree well at it, and nowhere else half as well. Sensors of other
// recordings correlate by 0.5 at most, good ones by 0.9 and more.
constexpr double kMinVariation = radians(3);  // per second, rms
constexpr double kMinTurnCorrelation = 0.8, kMinRatio = 2, kMaxDeviation = 0.005;
constexpr double kOwnPeak = 0.1;   // seconds: maxima nearer than this to the best are the same
constexpr double kInStep = 0.005;  // seconds: less is left to the filter
constexpr std::size_t kMinRates = 10;

/// A turn rate of the camera over a span, in its axes at the span's beginning.
struct TurnRate {
  Nanoseconds from = 0, to = 0;
  Vector3d rate = Vector3d::Zero();  ///< rad/s
};

/// Every so many-th of `frames` in pieces that are evenly spread; of a short recording all in one.
std::vector<std::vector<int>> clock_pieces(const Sequence& sequence, const std::vector<int>& frames) {
  const auto time = [&](std::size_t i) { return to_seconds(sequence.time(frames[i]) - sequence.time(frames.front())); };
  const double duration = time(frames.size() - 1);
  const bool whole = duration <= kClockPieces * kPieceSeconds;
  std::vector<std::vector<int>> pieces;
  for (int piece = 0; piece < (whole ? 1 : kClockPieces); ++piece) {
    const double begin = whole ? 0 : piece * (duration - kPieceSeconds) / (kClockPieces - 1);
    const double end = whole ? duration : begin + kPieceSeconds;
    pieces.emplace_back();
    double next = begin;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      if (time(i) < next || time(i) > end) continue;
      pieces.back().push_back(frames[i]);
      next = time(i) + kMinFrameInterval;
    }
  }
  return pieces;
}

/// Each frame against the first one at least a window later; gaps are left out.
void add_rates(const Trajectory& path, double window, std::vector<TurnRate>* rates) {
  for (std::size_t i = 0, j = 0; i < path.size(); ++i) {
    while (j < path.size() && to_seconds(path[j].time - path[i].time) < 0.999 * window) ++j;
    if (j == path.size()) return;
    const double span = to_seconds(path[j].time - path[i].time);
    if (span > 2 * window) continue;
    const Eigen::Matrix3d turn =
        path[i].world_from_camera.rotation().transpose() * path[j].world_from_camera.rotation();
    rates->push_back({path[i].time, path[j].time, so3::log(turn) / span});
  }
}

/// Sums of vectors a and b, for their correlation about the means.
struct VectorSums {
  double n = 0, aa = 0, bb = 0, ab = 0;
  Vector3d a = Vector3d::Zero(), b = Vector3d::Zero();

  void add(const Vector3d& u, const Vector3d& v) {
    n += 1, a += u, b += v;
    aa += u.squaredNorm(), bb += v.squaredNorm(), ab += u.dot(v);
  }
  double variation_a() const { return std::sqrt(std::max(0.0, aa - a.squaredNorm() / n) / n); }
  double correlation() const {
    const double va = aa - a.squaredNorm() / n, vb = bb - b.squaredNorm() / n;
    if (!(va > 1e-9 * n) || !(vb > 1e-9 * n)) return 0;
    return (ab - a.dot(b) / n) / std::sqrt(va * vb);
  }
};

/// Of the camera's rates with the sensor's, `offset` seconds added to its stamps; 0 where they share too little.
double correlation_at(double offset, const std::vector<TurnRate>& rates, const OrientationStream& sensor) {
  const Nanoseconds shift = from_seconds(offset);
  VectorSums sums;
  for (const TurnRate& rate : rates) {
    const OrientationReading a = sensor.lookup(rate.from - shift), b = sensor.lookup(rate.to - shift);
    if (a.status != OrientationStatus::ok || b.status != OrientationStatus::ok) continue;
    const Eigen::Matrix3d turn = a.earth_from_camera.transpose() * b.earth_from_camera;
    sums.add(rate.rate, so3::log(turn) / to_seconds(rate.to - rate.from));
  }
  if (sums.n < kMinRates || 2 * sums.n < static_cast<double>(rates.size())) return 0;
  return sums.correlation();
}

struct Peak {
  double offset = 0, correlation = 0, curvature = 0;  ///< per second²
};

/// The maxima of a curve that was sampled about `middle`, the highest first.
std::vector<Peak> peaks_of(const std::vector<double>& values, const OffsetSearch& search, double middle) {
  std::vector<Peak> peaks;
  for (std::size_t i = 1; i + 1 < values.size(); ++i) {
    const double a = values[i - 1], b = values[i], c = values[i + 1], bend = a - 2 * b + c;
    if (!(b > a) || !(b >= c) || !(b > 0)) continue;
    const double shift = 0.5 * (a - c) / bend;
    peaks.push_back({middle - search.longest + (static_cast<double>(i) + shift) * search.step,
                     b - 0.25 * (a - c) * shift, bend / (search.step * search.step)});
  }
  std::sort(peaks.begin(), peaks.end(), [](const Peak& a, const Peak& b) { return a.correlation > b.correlation; });
  return peaks;
}

/// Correlations at the offsets of the search, all or those near one.
std::vector<double> curve(const std::vector<TurnRate>& rates, const OrientationStream& sensor,
                          const OffsetSearch& search, double middle) {
  std::vector<double> values;
  const int steps = static_cast<int>(std::lround(2 * search.longest / search.step));
  for (int i = 0; i <= steps; ++i)
    values.push_back(correlation_at(middle - search.longest + i * search.step, rates, sensor));
  return values;
}

double unexplained(double correlation) { return 1 - correlation * correlation; }

/// Of the best offset, by what it is without one part of the motion or the other (jackknife): noise that changes
/// slowly, as a chip's error does, shows there and not in the formal value, which is the least that is told.
double deviation_of(const Peak& best, const std::vector<TurnRate>& rates, const OrientationStream& sensor,
                    double overlap) {
  constexpr std::size_t kParts = 5;
  OffsetSearch near;
  near.longest = kOwnPeak;
  double n = 0, sum = 0, squares = 0;
  for (std::size_t part = 0; part < kParts; ++part) {
    std::vector<TurnRate> others;
    for (std::size_t i = 0; i < rates.size(); ++i)
      if (i * kParts / rates.size() != part) others.push_back(rates[i]);
    const std::vector<Peak> peaks = peaks_of(curve(others, sensor, near, best.offset), near, best.offset);
    const double offset = peaks.empty() ? near.longest : peaks.front().offset - best.offset;
    n += 1, sum += offset, squares += offset * offset;
  }
  const double values = 3 * static_cast<double>(rates.size()) / overlap;
  const double formal =
      std::sqrt(unexplained(best.correlation) / (values * best.correlation * std::abs(best.curvature)));
  return std::max(formal, std::sqrt((n - 1) / n * std::max(0.0, squares - sum * sum / n)));
}

std::string clock_text(double offset, double sd) {
  if (offset == 0) return fmt::format("the sensor's clock is in step (± {:.1f} ms)", 1e3 * sd);
  return fmt::format("the sensor's stamps are {:.0f} ms {} (± {:.1f} ms)", 1e3 * std::abs(offset),
                     offset < 0 ? "late" : "early", 1e3 * sd);
}

/// The highest other peak, if there is one; what lies beside the best is a ripple on it.
std::optional<Peak> rival_of(const std::vector<Peak>& peaks) {
  for (const Peak& peak : peaks)
    if (std::abs(peak.offset - peaks.front().offset) > kOwnPeak) return peak;
  return std::nullopt;
}

ClockOffset unknown_clock(const std::string& why) {
  ClockOffset clock;
  clock.text = "the offset of the sensor's clock stays unknown: " + why;
  return clock;
}

ClockOffset judged(const Peak& best, const std::optional<Peak>& rival, double sd) {
  ClockOffset clock;
  if (best.correlation < kMinTurnCorrelation) {
    clock =
        unknown_clock(fmt::format("images and sensor turn alike at no offset (correlation {:.2f})", best.correlation));
  } else if (rival && unexplained(rival->correlation) < kMinRatio * unexplained(best.correlation)) {
    clock = unknown_clock(fmt::format("{:.0f} ms and {:.0f} ms fit as well, as the motion repeats", 1e3 * best.offset,
                                      1e3 * rival->offset));
  } else if (sd > kMaxDeviation) {
    clock = unknown_clock(fmt::format("the motion tells it to ± {:.0f} ms only", 1e3 * sd));
  } else {
    clock.is_sure = true;
    clock.offset = std::abs(best.offset) < std::max(kInStep, 3 * sd) ? 0 : best.offset;
    clock.text = clock_text(clock.offset, sd);
  }
  clock.sd = sd;
  clock.correlation = best.correlation;
  return clock;
}

ClockOffset compared(const std::vector<TurnRate>& rates, const OrientationStream& sensor, double overlap) {
  VectorSums camera;
  for (const TurnRate& rate : rates) camera.add(rate.rate, rate.rate);
  if (rates.size() < kMinRates || camera.variation_a() < kMinVariation)
    return unknown_clock("the camera hardly changes how it turns");
  const OffsetSearch search;
  const std::vector<Peak> peaks = peaks_of(curve(rates, sensor, search, 0), search, 0);
  if (peaks.empty()) return unknown_clock("images and sensor turn alike at no offset");
  const Peak& best = peaks.front();
  return judged(best, rival_of(peaks), deviation_of(best, rates, sensor, overlap));
}

}  // namespace

ClockOffset find_clock_offset(const Sequence& sequence, const std::vector<int>& frames, const OrientationStream& sensor,
                              const CalibrationOptions& options) {
  if (frames.size() < kMinRates) return compared({}, sensor, 1);
  CalibrationOptions fast = options;
  fast.parameters = fast_parameters(options.parameters.preprocess);
  // What is expected of the motion holds the camera back where it changes, so that it would seem late.
  fast.parameters.motion.steady = false;
  fast.parameters.tracking.speed_sigma = 0;
  PathTracker tracker(sequence, fast);
  std::vector<TurnRate> rates;
  std::vector<double> intervals;
  for (const std::vector<int>& piece : clock_pieces(sequence, frames)) {
    for (std::size_t i = 1; i < piece.size(); ++i)
      intervals.push_back(to_seconds(sequence.time(piece[i]) - sequence.time(piece[i - 1])));
    if (piece.size() < 2) continue;
    const double window = std::max(OffsetSearch().window, median(intervals));
    add_rates(tracker.track(piece, {}, nullptr).poses, window, &rates);
  }
  if (intervals.empty()) return compared({}, sensor, 1);
  const double interval = median(intervals);
  return compared(rates, sensor, std::max(1.0, OffsetSearch().window / interval));
}

}  // namespace plumbline
