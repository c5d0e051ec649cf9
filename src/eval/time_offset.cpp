#include "eval/time_offset.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "eval/rigid_alignment.h"
#include "plumbline/error.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"

namespace plumbline::eval {
namespace {

constexpr const char* kTimeOffsetWhere = "time offset";
constexpr std::size_t kMaxPoses = 20'000;
constexpr std::size_t kMinPoses = 3;
constexpr double kPrecision = 1e-5;  // seconds

bool is_earlier(const StampedPose& a, const StampedPose& b) { return a.time < b.time; }

/// Seconds after the reference's first stamp: small numbers, which a double holds to the nanosecond.
class Comparison {
 public:
  Comparison(const Trajectory& reference, const Trajectory& estimate, const TimeOffsetOptions& options) {
    const Nanoseconds zero = reference.front().time;
    for (const StampedPose& pose : reference) reference_times_.push_back(to_seconds(pose.time - zero));
    reference_.resize(3, static_cast<Eigen::Index>(reference.size()));
    for (std::size_t i = 0; i < reference.size(); ++i)
      reference_.col(static_cast<Eigen::Index>(i)) = reference[i].world_from_camera.translation();
    choose_poses(estimate, zero - options.offset, to_seconds(options.range));
  }

  std::size_t size() const { return times_.size(); }

  /// Root mean square of the distances after the alignment, metres, with the estimate's stamps later by `shift` s.
  double rmse(double shift) const {
    Eigen::Matrix3Xd target(3, estimate_.cols());
    std::size_t after = 1;
    for (std::size_t i = 0; i < times_.size(); ++i) {
      const double t = times_[i] + shift;
      while (after + 1 < reference_times_.size() && reference_times_[after] < t) ++after;
      const double begin = reference_times_[after - 1], end = reference_times_[after];
      const double part = end > begin ? std::clamp((t - begin) / (end - begin), 0.0, 1.0) : 0;
      const auto column = static_cast<Eigen::Index>(after);
      target.col(static_cast<Eigen::Index>(i)) =
          (1 - part) * reference_.col(column - 1) + part * reference_.col(column);
    }
    const SE3 motion = rigid_alignment(estimate_, target);
    const Eigen::Matrix3Xd difference = ((motion.rotation() * estimate_).colwise() + motion.translation()) - target;
    return std::sqrt(difference.squaredNorm() / static_cast<double>(times_.size()));
  }

 private:
  /// Those that every shift within the range leaves where the reference has poses on both sides.
  void choose_poses(const Trajectory& estimate, Nanoseconds zero, double range) {
    const double longest = longest_interval();
    std::vector<std::size_t> gaps(reference_times_.size(), 0);  // too long intervals that end at or before each stamp
    for (std::size_t i = 1; i < gaps.size(); ++i)
      gaps[i] = gaps[i - 1] + (reference_times_[i] - reference_times_[i - 1] > longest);
    std::vector<const StampedPose*> chosen;
    for (const StampedPose& pose : estimate) {
      const double t = to_seconds(pose.time - zero);
      if (t - range < 0 || t + range > reference_times_.back()) continue;
      const auto position = [&](double at) {
        return static_cast<std::size_t>(std::lower_bound(reference_times_.begin(), reference_times_.end(), at) -
                                        reference_times_.begin());
      };
      const std::size_t begin = position(t - range), end = position(t + range);
      if (gaps[end] == gaps[begin > 0 ? begin - 1 : 0]) chosen.push_back(&pose);
    }
    const std::size_t step = chosen.size() / kMaxPoses + 1;
    estimate_.resize(3, static_cast<Eigen::Index>((chosen.size() + step - 1) / step));
    for (std::size_t i = 0; i < chosen.size(); i += step) {
      estimate_.col(static_cast<Eigen::Index>(times_.size())) = chosen[i]->world_from_camera.translation();
      times_.push_back(to_seconds(chosen[i]->time - zero));
    }
  }

  /// Ten times the median: beyond it, a straight line says nothing about the way between.
  double longest_interval() const {
    std::vector<double> intervals;
    for (std::size_t i = 1; i < reference_times_.size(); ++i)
      intervals.push_back(reference_times_[i] - reference_times_[i - 1]);
    const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
    std::nth_element(intervals.begin(), middle, intervals.end());
    return 10 * *middle;
  }

  std::vector<double> reference_times_, times_;
  Eigen::Matrix3Xd reference_, estimate_;
};

/// The minimum of a function with one valley in [low, high] (Kiefer 1953).
template <class Function>
double golden_section(Function&& f, double low, double high) {
  constexpr double kGolden = 1 / std::numbers::phi;
  double a = high - kGolden * (high - low), b = low + kGolden * (high - low), fa = f(a), fb = f(b);
  while (high - low > kPrecision) {
    if (fa < fb) {
      high = b;
      b = a;
      fb = fa;
      fa = f(a = high - kGolden * (high - low));
    } else {
      low = a;
      a = b;
      fa = fb;
      fb = f(b = low + kGolden * (high - low));
    }
  }
  return (low + high) / 2;
}

void validate(const Trajectory& reference, const Trajectory& estimate, const TimeOffsetOptions& options) {
  if (options.range <= 0)
    throw Error("the range to search is not positive", kTimeOffsetWhere, "give a range in seconds");
  for (const Trajectory* trajectory : {&reference, &estimate}) {
    if (!std::is_sorted(trajectory->begin(), trajectory->end(), is_earlier))
      throw Error("the poses are not in order of time", kTimeOffsetWhere, "sort them");
  }
}

}  // namespace

TimeOffset best_time_offset(const Trajectory& reference, const Trajectory& estimate, const TimeOffsetOptions& options) {
  validate(reference, estimate, options);
  const auto too_few = [&](std::size_t count) {
    return Error("only " + std::to_string(count) + " poses lie within the reference at every offset that is searched",
                 kTimeOffsetWhere, "search a smaller range, or give a time offset");
  };
  if (reference.size() < 2) throw too_few(0);
  const Comparison comparison(reference, estimate, options);
  if (comparison.size() < kMinPoses) throw too_few(comparison.size());

  const double range = to_seconds(options.range);
  const int steps = std::max(40, static_cast<int>(std::ceil(range / 0.01)));  // to either side
  const double step = range / steps;
  std::vector<double> errors;
  for (int i = -steps; i <= steps; ++i) errors.push_back(comparison.rmse(i * step));
  const auto lowest = std::min_element(errors.begin(), errors.end());
  const double coarse = static_cast<double>(lowest - errors.begin() - steps) * step;
  const auto rmse = [&](double shift) { return comparison.rmse(shift); };
  const double best = golden_section(rmse, std::max(-range, coarse - step), std::min(range, coarse + step));
  return {.best = options.offset + from_seconds(best),
          .rmse = comparison.rmse(best),
          .rmse_as_given = errors[static_cast<std::size_t>(steps)],
          .poses = comparison.size(),
          .at_the_border = lowest == errors.begin() || lowest + 1 == errors.end()};
}

}  // namespace plumbline::eval
