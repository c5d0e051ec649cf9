#include "eval/trajectory_error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <queue>
#include <random>
#include <string>
#include <tuple>

#include "core/error.h"

namespace plumbline::eval {
namespace {

constexpr const char* kWhere = "trajectory evaluation";

/// Exact for any two stamps; the difference of the extremes does not fit in a signed number.
std::uint64_t gap(Nanoseconds a, Nanoseconds b) {
  return a < b ? static_cast<std::uint64_t>(b) - static_cast<std::uint64_t>(a)
               : static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b);
}

/// Stamps in order of time, on one clock, with where they came from.
struct Timeline {
  std::vector<Nanoseconds> times;
  std::vector<std::size_t> indices;

  std::size_t size() const { return times.size(); }

  /// Position of the stamp nearest to t; the earlier one of two as near.
  std::size_t nearest(Nanoseconds t) const {
    const auto after = std::lower_bound(times.begin(), times.end(), t);
    const auto position = static_cast<std::size_t>(after - times.begin());
    if (position == 0) return 0;
    if (position == size()) return position - 1;
    return gap(times[position - 1], t) <= gap(times[position], t) ? position - 1 : position;
  }
};

Timeline make_timeline(const Trajectory& trajectory, Nanoseconds offset, const std::string& name) {
  Timeline line;
  line.indices.resize(trajectory.size());
  std::iota(line.indices.begin(), line.indices.end(), std::size_t{0});
  std::stable_sort(line.indices.begin(), line.indices.end(),
                   [&](std::size_t a, std::size_t b) { return trajectory[a].time < trajectory[b].time; });
  line.times.reserve(trajectory.size());
  for (const std::size_t i : line.indices) {
    Nanoseconds time = 0;
    if (__builtin_add_overflow(trajectory[i].time, offset, &time)) {
      throw Error("a time stamp of the " + name + " leaves the range of 64-bit nanoseconds", kWhere,
                  "check the time offset");
    }
    if (!trajectory[i].world_from_camera.is_finite()) {
      throw Error("pose " + std::to_string(i) + " of the " + name + " (t = " + format_seconds(trajectory[i].time) +
                      ") is not finite",
                  kWhere, "remove it");
    }
    line.times.push_back(time);
  }
  return line;
}

/// Both lines merged by time, as a doubly linked list from which pairs are taken out.
class MergedLines {
 public:
  MergedLines(const Timeline& reference, const Timeline& estimate) {
    nodes_.reserve(reference.size() + estimate.size());
    std::size_t r = 0, e = 0;
    while (r < reference.size() || e < estimate.size()) {
      const bool take_reference =
          e == estimate.size() || (r < reference.size() && reference.times[r] <= estimate.times[e]);
      const std::size_t position = take_reference ? r++ : e++;
      const Nanoseconds time = (take_reference ? reference : estimate).times[position];
      const auto self = static_cast<std::ptrdiff_t>(nodes_.size());
      nodes_.push_back({time, position, self - 1, self + 1, take_reference, true});
    }
  }

  struct Node {
    Nanoseconds time;
    std::size_t position;  ///< in its line
    std::ptrdiff_t previous, next;
    bool is_reference, present;
  };

  std::ptrdiff_t size() const { return static_cast<std::ptrdiff_t>(nodes_.size()); }
  bool has(std::ptrdiff_t node) const { return node >= 0 && node < size(); }
  const Node& operator[](std::ptrdiff_t node) const { return nodes_[static_cast<std::size_t>(node)]; }

  /// Takes out neighbours; returns those that become neighbours, either of which may be no node.
  std::pair<std::ptrdiff_t, std::ptrdiff_t> remove(std::ptrdiff_t left, std::ptrdiff_t right) {
    at(left).present = at(right).present = false;
    const std::ptrdiff_t before = at(left).previous, after = at(right).next;
    if (has(before)) at(before).next = after;
    if (has(after)) at(after).previous = before;
    return {before, after};
  }

 private:
  Node& at(std::ptrdiff_t node) { return nodes_[static_cast<std::size_t>(node)]; }
  std::vector<Node> nodes_;
};

struct Candidate {
  std::uint64_t gap;
  std::size_t reference, estimate;  ///< positions in the lines
  std::ptrdiff_t left, right;       ///< nodes

  bool operator>(const Candidate& o) const {
    return std::tie(gap, reference, estimate) > std::tie(o.gap, o.reference, o.estimate);
  }
};

/// The closest pair of a reference and an estimated stamp is always adjacent among the stamps that remain, so a heap of
/// adjacent pairs gives the same greedy matching as the tool's sorted list of *all* pairs, in O(n log n) however dense
/// the stamps are. Returns positions in the lines, in order of time.
std::vector<Association> match(const Timeline& reference, const Timeline& estimate, Nanoseconds max_difference) {
  MergedLines lines(reference, estimate);
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> heap;
  const auto propose = [&](std::ptrdiff_t left, std::ptrdiff_t right) {
    if (!lines.has(left) || !lines.has(right)) return;
    const auto &a = lines[left], &b = lines[right];
    if (a.is_reference == b.is_reference) return;
    const std::uint64_t distance = gap(a.time, b.time);
    if (max_difference <= 0 || distance >= static_cast<std::uint64_t>(max_difference)) return;
    const auto [r, e] = a.is_reference ? std::pair(a.position, b.position) : std::pair(b.position, a.position);
    heap.push({distance, r, e, left, right});
  };
  for (std::ptrdiff_t i = 0; i + 1 < lines.size(); ++i) propose(i, i + 1);

  std::vector<Association> pairs;
  while (!heap.empty()) {
    const Candidate best = heap.top();
    heap.pop();
    if (!lines[best.left].present || !lines[best.right].present) continue;
    pairs.push_back({best.reference, best.estimate});
    const auto [before, after] = lines.remove(best.left, best.right);
    propose(before, after);
  }
  std::sort(pairs.begin(), pairs.end(), [](const auto& a, const auto& b) { return a.reference < b.reference; });
  return pairs;
}

[[noreturn]] void throw_too_few(const Timeline& reference, const Timeline& estimate, std::size_t found,
                                std::size_t needed, const std::string& what) {
  if (reference.size() == 0 || estimate.size() == 0) {
    throw Error(std::string("the ") + (reference.size() == 0 ? "reference" : "estimate") + " has no poses", kWhere,
                "give a trajectory that has some");
  }
  const auto seconds = [](std::uint64_t ns) { return std::to_string(static_cast<double>(ns) * 1e-9) + " s "; };
  if (estimate.times.front() > reference.times.back()) {
    throw Error("the trajectories do not overlap in time: the estimate begins " +
                    seconds(gap(estimate.times.front(), reference.times.back())) + "after the reference ends",
                kWhere, "check that they belong to one sequence, or give a time offset");
  }
  if (estimate.times.back() < reference.times.front()) {
    throw Error("the trajectories do not overlap in time: the estimate ends " +
                    seconds(gap(estimate.times.back(), reference.times.front())) + "before the reference begins",
                kWhere, "check that they belong to one sequence, or give a time offset");
  }
  throw Error("only " + std::to_string(found) + " " + what + " of the trajectories found, at least " +
                  std::to_string(needed) + " are needed",
              kWhere, "check the time offset and the longest permitted difference of stamps");
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

SE3 align(const Eigen::Matrix3Xd& estimate, const Eigen::Matrix3Xd& reference) {
  const Eigen::Matrix4d t = Eigen::umeyama(estimate, reference, false);
  return {t.topLeftCorner<3, 3>(), t.topRightCorner<3, 1>()};
}

// ---- relative error

/// [0, 1). The engine's numbers are prescribed by the standard, those of its distributions are not.
double uniform(std::mt19937_64* random) { return static_cast<double>((*random)() >> 11) * 0x1p-53; }

std::size_t uniform_index(std::mt19937_64* random, std::size_t count) {
  return std::min(count - 1, static_cast<std::size_t>(uniform(random) * static_cast<double>(count)));
}

using PositionPairs = std::vector<std::pair<std::size_t, std::size_t>>;

/// Where each estimated pose stands on the axis along which `delta` is measured.
std::vector<double> measure(const Trajectory& estimate, const Timeline& line, DeltaUnit unit) {
  std::vector<double> along(line.size(), 0.0);
  for (std::size_t i = 1; i < line.size(); ++i) {
    const SE3& before = estimate[line.indices[i - 1]].world_from_camera;
    const SE3& now = estimate[line.indices[i]].world_from_camera;
    double step = 1;
    if (unit == DeltaUnit::seconds) step = static_cast<double>(gap(line.times[i - 1], line.times[i])) * 1e-9;
    if (unit == DeltaUnit::metres) step = (now.translation() - before.translation()).norm();
    if (unit == DeltaUnit::radians) step = so3::angle(before.rotation().transpose() * now.rotation());
    along[i] = along[i - 1] + step;
  }
  return along;
}

/// Position of the value nearest to `target` in an ordered list.
std::size_t nearest(const std::vector<double>& ordered, double target) {
  const auto after = std::lower_bound(ordered.begin(), ordered.end(), target);
  const auto position = static_cast<std::size_t>(after - ordered.begin());
  if (position == 0) return 0;
  if (position == ordered.size()) return position - 1;
  return target - ordered[position - 1] <= ordered[position] - target ? position - 1 : position;
}

PositionPairs fixed_pairs(const std::vector<double>& along, const RelativeErrorOptions& options) {
  PositionPairs pairs;
  for (std::size_t i = 0; i < along.size(); ++i) {
    const std::size_t j = nearest(along, along[i] + options.delta);
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
  constexpr double kMostPairs = 1e8;
  PositionPairs pairs;
  const double total = static_cast<double>(count) * static_cast<double>(count);
  if (options.max_pairs == 0 || total <= static_cast<double>(options.max_pairs)) {
    if (total > kMostPairs) {
      throw Error("all pairs of " + std::to_string(count) + " poses are too many", kWhere, "set max_pairs");
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

/// Position in the reference's line for each position in the estimate's, where one is near enough in time.
std::vector<std::optional<std::size_t>> nearest_references(const Timeline& reference, const Timeline& estimate) {
  std::vector<std::optional<std::size_t>> found(estimate.size());
  if (reference.size() == 0) return found;
  const std::uint64_t limit = 2 * median_interval(reference);
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    const std::size_t r = reference.nearest(estimate.times[i]);
    if (gap(reference.times[r], estimate.times[i]) <= limit) found[i] = r;
  }
  return found;
}

void validate(const RelativeErrorOptions& options) {
  if (!options.all_pairs && !(options.delta > 0 && std::isfinite(options.delta))) {
    throw Error("the distance between the poses of a pair is not positive", kWhere, "give a positive delta");
  }
}

}  // namespace

std::vector<Association> associate(const Trajectory& reference, const Trajectory& estimate,
                                   const AssociationOptions& options) {
  const Timeline r = make_timeline(reference, 0, "reference");
  const Timeline e = make_timeline(estimate, options.offset, "estimate");
  std::vector<Association> pairs = match(r, e, options.max_difference);
  for (Association& pair : pairs) pair = {r.indices[pair.reference], e.indices[pair.estimate]};
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
  for (const Association& m : matches) error.pairs.push_back({m.reference, m.estimate, 0});
  const Eigen::Matrix3Xd target = positions(reference, error.pairs, &AbsoluteError::Pair::reference);
  const Eigen::Matrix3Xd source = positions(estimate, error.pairs, &AbsoluteError::Pair::estimate);
  error.reference_from_estimate = align(source, target);

  std::vector<double> distances;
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
  const auto references = nearest_references(r, e);

  RelativeError error;
  std::vector<double> translations, rotations;
  for (const auto& [i, j] : pairs) {
    if (!references[i] || !references[j]) continue;
    const RelativeError::Pair indices{e.indices[i], e.indices[j], r.indices[*references[i]], r.indices[*references[j]]};
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
