#include "plumbline/evaluation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <string>

#include "core/random.h"
#include "eval/rigid_alignment.h"
#include "plumbline/error.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"

namespace plumbline::eval {
namespace {

constexpr const char* kTrajectoryErrorWhere = "trajectory evaluation";

/// Exact for any two stamps; the difference of the extremes does not fit in a signed number.
std::uint64_t gap(Nanoseconds a, Nanoseconds b) {
  return a < b ? static_cast<std::uint64_t>(b) - static_cast<std::uint64_t>(a)
               : static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b);
}

/// Stamps in order of time, on one clock, with where they came from.
struct Timeline {
  std::vector<Nanoseconds> times;
  std::vector<std::size_t> indices;  ///< in the trajectory; empty if that is in order itself

  std::size_t size() const { return times.size(); }
  std::size_t index(std::size_t position) const { return indices.empty() ? position : indices[position]; }

  /// Position of the stamp nearest to t; the earlier one of two as near.
  std::size_t nearest(Nanoseconds t) const {
    const auto after = std::lower_bound(times.begin(), times.end(), t);
    const auto position = static_cast<std::size_t>(after - times.begin());
    if (position == 0) return 0;
    if (position == size()) return position - 1;
    return gap(times[position - 1], t) <= gap(times[position], t) ? position - 1 : position;
  }
};

/// Empty where the trajectory is in order of time.
std::vector<std::size_t> order_by_time(const Trajectory& trajectory) {
  const auto by_time = [](const StampedPose& a, const StampedPose& b) { return a.time < b.time; };
  std::vector<std::size_t> order;
  if (std::is_sorted(trajectory.begin(), trajectory.end(), by_time)) return order;
  order.resize(trajectory.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return trajectory[a].time < trajectory[b].time; });
  return order;
}

Nanoseconds shifted(Nanoseconds time, Nanoseconds offset, const std::string& name) {
  if (__builtin_add_overflow(time, offset, &time))
    throw Error("a time stamp of the " + name + " leaves the range of 64-bit nanoseconds", kTrajectoryErrorWhere,
                "check the time offset");
  return time;
}

Timeline make_timeline(const Trajectory& trajectory, Nanoseconds offset, const std::string& name) {
  Timeline line;
  line.indices = order_by_time(trajectory);
  line.times.reserve(trajectory.size());
  for (std::size_t position = 0; position < trajectory.size(); ++position) {
    const std::size_t i = line.index(position);
    if (!trajectory[i].world_from_camera.is_finite()) {
      throw Error("pose " + std::to_string(i) + " of the " + name + " (t = " + format_seconds(trajectory[i].time) +
                      ") is not finite",
                  kTrajectoryErrorWhere, "remove it");
    }
    line.times.push_back(shifted(trajectory[i].time, offset, name));
  }
  return line;
}

/// Positions, halved in memory.
using Position = std::uint32_t;
constexpr Position kNone = std::numeric_limits<Position>::max();

/// Positions 0 … count − 1 that are still free, and the nearest free one on either side of any: union-find with path
/// halving (Tarjan, van Leeuwen 1984), nearly constant time.
class FreePositions {
 public:
  explicit FreePositions(std::size_t count) : up_(count + 2), down_(count + 2) {
    std::iota(up_.begin(), up_.end(), Position{0});
    down_ = up_;
  }

  bool has(Position p) const { return up_[p + 1] == p + 1; }
  void take(Position p) {
    up_[p + 1] = p + 2;
    down_[p + 1] = p;
  }
  /// The first free one that is not before p, which may be count; kNone if there is none.
  Position not_before(Position p) {
    const Position found = find(&up_, p + 1);
    return found + 1 == up_.size() ? kNone : found - 1;
  }
  /// The last free one before p.
  Position before(Position p) { return find(&down_, p) - 1; }  // the border at 0 wraps to kNone

 private:
  static Position find(std::vector<Position>* parents, Position p) {
    std::vector<Position>& parent = *parents;
    while (parent[p] != p) p = parent[p] = parent[parent[p]];
    return p;
  }
  std::vector<Position> up_, down_;  // shifted by one: always free borders stand on both sides
};

/// One of the two lines that are matched.
struct Side {
  const std::vector<Nanoseconds>& times;
  FreePositions free;
  std::vector<Position> after;  ///< for each stamp, the first position of the other line that is not earlier

  Side(const Timeline& own, const Timeline& other) : times(own.times), free(own.size()) {
    after.reserve(own.size());
    std::size_t position = 0;
    for (const Nanoseconds t : times) {
      while (position < other.size() && other.times[position] < t) ++position;
      after.push_back(static_cast<Position>(position));
    }
  }
};

/// The free stamp of `other` nearest to `own.times[position]` (of two as near, the lower position) if that is nearer
/// than `limit`.
Position nearest_free(const Side& own, Side* other, Position position, std::uint64_t limit) {
  const Nanoseconds t = own.times[position];
  Position left = other->free.before(own.after[position]);
  const Position right = other->free.not_before(own.after[position]);
  const auto distance = [&](Position p) { return p == kNone ? limit : gap(other->times[p], t); };
  const std::uint64_t left_gap = distance(left), right_gap = distance(right);
  if (std::min(left_gap, right_gap) >= limit) return kNone;
  if (right_gap < left_gap) return right;
  if (left > 0 && other->times[left - 1] == other->times[left]) {  // the first of doubled stamps
    const auto first = std::lower_bound(other->times.begin(), other->times.begin() + left, other->times[left]);
    left = other->free.not_before(static_cast<Position>(first - other->times.begin()));
  }
  return left;
}

/// Two stamps that are each other's nearest free partner are matched by the benchmark's tool, whatever else it does
/// before: taking others out never brings a nearer one. Following nearest partners from any stamp ends at such a pair
/// (the chain of Benzécri 1982 for hierarchical clustering), so the greedy matching over the sorted list of *all* pairs
/// comes out in nearly linear time however dense the stamps are. Returns positions in the lines, in order of time.
std::vector<Association> match(const Timeline& reference, const Timeline& estimate, Nanoseconds max_difference) {
  if (std::max(reference.size(), estimate.size()) > kNone - 2) {
    throw Error("the trajectories have more than 4 billion poses", kTrajectoryErrorWhere, "evaluate parts of them");
  }
  const auto limit = static_cast<std::uint64_t>(std::max<Nanoseconds>(0, max_difference));
  std::array<Side, 2> sides = {Side(estimate, reference), Side(reference, estimate)};
  std::vector<Position> partner(reference.size(), kNone), chain;
  for (Position start = 0; start < estimate.size(); ++start) {
    if (!sides[0].free.has(start)) continue;
    chain = {start};
    while (!chain.empty()) {
      const std::size_t side = (chain.size() - 1) % 2;  // estimates and references take turns
      const Position next = nearest_free(sides[side], &sides[1 - side], chain.back(), limit);
      if (next == kNone) {
        chain.pop_back();
      } else if (chain.size() < 2 || next != chain[chain.size() - 2]) {
        chain.push_back(next);
      } else {
        const Position e = side == 0 ? chain.back() : next, r = side == 0 ? next : chain.back();
        sides[0].free.take(e);
        sides[1].free.take(r);
        partner[r] = e;
        chain.resize(chain.size() - 2);
      }
    }
  }
  std::vector<Association> pairs;
  pairs.reserve(std::min(reference.size(), estimate.size()));
  for (std::size_t r = 0; r < partner.size(); ++r) {
    if (partner[r] != kNone) pairs.push_back({r, partner[r]});
  }
  return pairs;
}

[[noreturn]] void throw_too_few(const Timeline& reference, const Timeline& estimate, std::size_t found,
                                std::size_t needed, const std::string& what) {
  if (reference.size() == 0 || estimate.size() == 0) {
    throw Error(std::string("the ") + (reference.size() == 0 ? "reference" : "estimate") + " has no poses",
                kTrajectoryErrorWhere, "give a trajectory that has some");
  }
  const auto seconds = [](std::uint64_t ns) { return std::to_string(static_cast<double>(ns) * 1e-9) + " s "; };
  if (estimate.times.front() > reference.times.back()) {
    throw Error("the trajectories do not overlap in time: the estimate begins " +
                    seconds(gap(estimate.times.front(), reference.times.back())) + "after the reference ends",
                kTrajectoryErrorWhere, "check that they belong to one sequence, or give a time offset");
  }
  if (estimate.times.back() < reference.times.front()) {
    throw Error("the trajectories do not overlap in time: the estimate ends " +
                    seconds(gap(estimate.times.back(), reference.times.front())) + "before the reference begins",
                kTrajectoryErrorWhere, "check that they belong to one sequence, or give a time offset");
  }
  throw Error("only " + std::to_string(found) + " " + what + " of the trajectories found, at least " +
                  std::to_string(needed) + " are needed",
              kTrajectoryErrorWhere, "check the time offset and the longest permitted difference of stamps");
}

/// Columns are positions in metres.
Eigen::Matrix3Xd positions(const Trajectory& trajectory, const std::vector<AbsoluteError::Pair>& pairs,
                           std::size_t AbsoluteError::Pair::*index) {
  Eigen::Matrix3Xd columns(3, static_cast<Eigen::Index>(pairs.size()));
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    columns.col(static_cast<Eigen::Index>(i)) = trajectory[pairs[i].*index].world_from_camera.translation();
  }
  return columns;
}

// ---- relative error

std::size_t uniform_index(std::mt19937_64* random, std::size_t count) {
  return std::min(count - 1, static_cast<std::size_t>(uniform(random) * static_cast<double>(count)));
}

using PositionPairs = std::vector<std::pair<std::size_t, std::size_t>>;

/// Where each estimated pose stands on the axis along which `delta` is measured.
std::vector<double> measure(const Trajectory& estimate, const Timeline& line, DeltaUnit unit) {
  std::vector<double> along(line.size(), 0.0);
  for (std::size_t i = 1; i < line.size(); ++i) {
    const SE3& before = estimate[line.index(i - 1)].world_from_camera;
    const SE3& now = estimate[line.index(i)].world_from_camera;
    double step = 1;
    if (unit == DeltaUnit::seconds) step = static_cast<double>(gap(line.times[i - 1], line.times[i])) * 1e-9;
    if (unit == DeltaUnit::metres) step = (now.translation() - before.translation()).norm();
    if (unit == DeltaUnit::radians) step = so3::angle(before.rotation().transpose() * now.rotation());
    along[i] = along[i - 1] + step;
  }
  return along;
}

PositionPairs fixed_pairs(const std::vector<double>& along, const RelativeErrorOptions& options) {
  PositionPairs pairs;
  pairs.reserve(along.size());
  std::size_t after = 0;  // the first pose that is not nearer than delta
  for (std::size_t i = 0; i < along.size(); ++i) {
    const double target = along[i] + options.delta;
    while (after < along.size() && along[after] < target) ++after;
    const bool take_before = after > 0 && (after == along.size() || target - along[after - 1] <= along[after] - target);
    const std::size_t j = take_before ? after - 1 : after;
    if (j + 1 != along.size()) pairs.emplace_back(i, j);
  }
  if (options.max_pairs == 0 || pairs.size() <= options.max_pairs) return pairs;
  // The head of a Fisher–Yates shuffle is a sample without replacement.
  std::mt19937_64 random(options.seed);
  for (std::size_t i = 0; i < options.max_pairs; ++i) {
    std::swap(pairs[i], pairs[i + uniform_index(&random, pairs.size() - i)]);
  }
  pairs.resize(options.max_pairs);
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

PositionPairs all_pairs(std::size_t count, const RelativeErrorOptions& options) {
  constexpr double kMaxPairs = 1e8;
  PositionPairs pairs;
  const double total = static_cast<double>(count) * static_cast<double>(count);
  if (options.max_pairs == 0 || total <= static_cast<double>(options.max_pairs)) {
    if (total > kMaxPairs) {
      throw Error("all pairs of " + std::to_string(count) + " poses are too many", kTrajectoryErrorWhere,
                  "set max_pairs");
    }
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t j = 0; j < count; ++j) pairs.emplace_back(i, j);
    }
    return pairs;
  }
  std::mt19937_64 random(options.seed);
  for (std::size_t k = 0; k < options.max_pairs; ++k) {
    const std::size_t i = uniform_index(&random, count);
    pairs.emplace_back(i, uniform_index(&random, count));
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

std::uint64_t median_interval(const Timeline& line) {
  std::vector<std::uint64_t> intervals;
  for (std::size_t i = 1; i < line.size(); ++i) intervals.push_back(gap(line.times[i - 1], line.times[i]));
  if (intervals.empty()) return 0;
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  if (intervals.size() % 2 == 1) return *middle;
  const std::uint64_t below = *std::max_element(intervals.begin(), middle);
  return below + (*middle - below) / 2;
}

/// The reference's pose nearest in time to an estimated one, where it is near enough.
class NearestReference {
 public:
  NearestReference(const Timeline& reference, const Timeline& estimate)
      : reference_(reference), estimate_(estimate), limit_(2 * median_interval(reference)) {}

  /// Positions in the lines.
  std::optional<std::size_t> operator()(std::size_t position) const {
    if (reference_.size() == 0) return std::nullopt;
    const std::size_t r = reference_.nearest(estimate_.times[position]);
    if (gap(reference_.times[r], estimate_.times[position]) > limit_) return std::nullopt;
    return r;
  }

 private:
  const Timeline &reference_, &estimate_;
  std::uint64_t limit_;
};

void validate(const RelativeErrorOptions& options) {
  if (!options.all_pairs && !(options.delta > 0 && std::isfinite(options.delta))) {
    throw Error("the distance between the poses of a pair is not positive", kTrajectoryErrorWhere,
                "give a positive delta");
  }
}

}  // namespace

std::vector<Association> associate(const Trajectory& reference, const Trajectory& estimate,
                                   const AssociationOptions& options) {
  const Timeline r = make_timeline(reference, 0, "reference");
  const Timeline e = make_timeline(estimate, options.offset, "estimate");
  std::vector<Association> pairs = match(r, e, options.max_difference);
  for (Association& pair : pairs) pair = {r.index(pair.reference), e.index(pair.estimate)};
  return pairs;
}

AbsoluteError absolute_trajectory_error(const Trajectory& reference, const Trajectory& estimate,
                                        const AssociationOptions& options) {
  const std::vector<Association> matches = associate(reference, estimate, options);
  constexpr std::size_t kNeeded = 3;
  if (matches.size() < kNeeded) {
    throw_too_few(make_timeline(reference, 0, "reference"), make_timeline(estimate, options.offset, "estimate"),
                  matches.size(), kNeeded, "pairs of poses");
  }
  AbsoluteError error;
  error.pairs.reserve(matches.size());
  for (const Association& m : matches) error.pairs.push_back({m.reference, m.estimate, 0});
  const Eigen::Matrix3Xd target = positions(reference, error.pairs, &AbsoluteError::Pair::reference);
  const Eigen::Matrix3Xd source = positions(estimate, error.pairs, &AbsoluteError::Pair::estimate);
  error.reference_from_estimate = rigid_alignment(source, target);

  std::vector<double> distances;
  distances.reserve(error.pairs.size());
  for (std::size_t i = 0; i < error.pairs.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    const Eigen::Vector3d aligned = error.reference_from_estimate * Eigen::Vector3d(source.col(column));
    error.pairs[i].translation = (aligned - target.col(column)).norm();
    distances.push_back(error.pairs[i].translation);
  }
  error.translation = statistics(distances);
  return error;
}

RelativeError relative_trajectory_error(const Trajectory& reference, const Trajectory& estimate,
                                        const RelativeErrorOptions& options) {
  validate(options);
  const Timeline r = make_timeline(reference, 0, "reference");
  const Timeline e = make_timeline(estimate, options.offset, "estimate");
  PositionPairs pairs;
  if (e.size() > 0) {
    pairs = options.all_pairs ? all_pairs(e.size(), options) : fixed_pairs(measure(estimate, e, options.unit), options);
  }
  const NearestReference nearest_reference(r, e);

  RelativeError error;
  std::vector<double> translations, rotations;
  for (const auto& [i, j] : pairs) {
    const auto first = nearest_reference(i), second = nearest_reference(j);
    if (!first || !second) continue;
    const RelativeError::Pair indices{e.index(i), e.index(j), r.index(*first), r.index(*second)};
    const SE3 estimated = estimate[indices.estimate_second].world_from_camera.inverse() *
                          estimate[indices.estimate_first].world_from_camera;
    const SE3 true_motion = reference[indices.reference_second].world_from_camera.inverse() *
                            reference[indices.reference_first].world_from_camera;
    const SE3 difference = estimated.inverse() * true_motion;
    error.pairs.push_back(indices);
    error.pairs.back().translation = difference.translation().norm();
    error.pairs.back().rotation = so3::angle(difference.rotation());
    translations.push_back(error.pairs.back().translation);
    rotations.push_back(error.pairs.back().rotation);
  }
  constexpr std::size_t kNeeded = 2;
  if (error.pairs.size() < kNeeded) throw_too_few(r, e, error.pairs.size(), kNeeded, "pairs of relative motions");
  error.translation = statistics(translations);
  error.rotation = statistics(rotations);
  return error;
}

}  // namespace plumbline::eval
