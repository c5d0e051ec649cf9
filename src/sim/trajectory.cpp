#include "sim/trajectory.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "core/random.h"
#include "plumbline/error.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"
#include "sim/analytic_scene.h"

namespace plumbline::sim {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr const char* kTrajectoryWhere = "trajectory";
constexpr double kControlInterval = 0.04;  ///< seconds; a hand moves little above 6 Hz

// ---- regression

struct Sample {
  double t;
  SE3 pose;
};

/// Weighted quadratic through values at times about `t0`: its value there.
Eigen::Matrix<double, 6, 1> quadratic_at(const std::vector<double>& times, const std::vector<Vector6d>& values,
                                         const std::vector<double>& weights) {
  Matrix3d normal = Matrix3d::Zero();
  Eigen::Matrix<double, 3, 6> right = Eigen::Matrix<double, 3, 6>::Zero();
  for (std::size_t i = 0; i < times.size(); ++i) {
    const Vector3d basis(1, times[i], times[i] * times[i]);
    normal += weights[i] * basis * basis.transpose();
    right += weights[i] * basis * values[i].transpose();
  }
  return normal.ldlt().solve(right).row(0).transpose();
}

/// Across a gap of the capture nothing is known: the straight way from its one end to the other.
SE3 bridge(const Sample& before, const Sample& after, double t) {
  const double share = (t - before.t) / (after.t - before.t);
  const Vector3d turn = so3::log(before.pose.rotation().transpose() * after.pose.rotation());
  return {before.pose.rotation() * so3::exp(share * turn),
          before.pose.translation() + share * (after.pose.translation() - before.pose.translation())};
}

/// Pose of the local regression at t0; the window grows until it holds five samples.
SE3 regress(const std::vector<Sample>& samples, double t0, double window) {
  const auto by_time = [](const Sample& s, double t) { return s.t < t; };
  const auto middle = std::lower_bound(samples.begin(), samples.end(), t0, by_time);
  if (middle != samples.begin() && middle != samples.end() && middle->t - (middle - 1)->t > 4 * window)
    return bridge(*(middle - 1), *middle, t0);
  auto first = std::lower_bound(samples.begin(), samples.end(), t0 - window, by_time);
  auto last = std::lower_bound(samples.begin(), samples.end(), t0 + window, by_time);
  constexpr std::ptrdiff_t kMinSamples = 5;
  while (last - first < kMinSamples) {
    if (first != samples.begin()) --first;
    if (last != samples.end()) ++last;
  }
  const double reach = 1.01 * std::max({window, t0 - first->t, (last - 1)->t - t0});
  const SE3& origin = (middle == samples.end() ? samples.back() : *middle).pose;
  std::vector<double> times, weights;
  std::vector<Vector6d> values;
  for (auto s = first; s != last; ++s) {
    const double share = std::abs(s->t - t0) / reach, tricube = 1 - share * share * share;
    Vector6d value;
    value << so3::log(s->pose.rotation() * origin.rotation().transpose()), s->pose.translation() - origin.translation();
    times.push_back((s->t - t0) / reach);
    weights.push_back(tricube * tricube * tricube);
    values.push_back(value);
  }
  const Vector6d value = quadratic_at(times, values, weights);
  return {so3::exp(value.head<3>()) * origin.rotation(), value.tail<3>() + origin.translation()};
}

// ---- made-up paths

/// Band-limited noise of unit rms: a sum of sines between two frequencies (Hz).
class Tremor {
 public:
  Tremor(std::uint64_t key, double low, double high) {
    Random random(key);
    for (Sine& sine : sines_) sine = {random.uniform(low, high), random.uniform(0, 2 * std::numbers::pi)};
  }

  double at(double seconds) const {
    double sum = 0;
    for (const Sine& s : sines_) sum += std::sin(2 * std::numbers::pi * s.frequency * seconds + s.phase);
    return sum * std::sqrt(2.0 / kSines);
  }

 private:
  static constexpr int kSines = 7;
  struct Sine {
    double frequency, phase;
  };
  std::array<Sine, kSines> sines_{};
};

/// Three of them, for a vector.
struct Tremor3 {
  Tremor x, y, z;
  Tremor3(std::uint64_t key, double low, double high)
      : x(stream(key, 1), low, high), y(stream(key, 2), low, high), z(stream(key, 3), low, high) {}
  Vector3d at(double t) const { return {x.at(t), y.at(t), z.at(t)}; }
};

struct Frame3 {
  Vector3d focus;
  double radius, height;
};

SE3 orbit_view(const Frame3& f, const PathOptions& o, double t) {
  const double phase = 2 * std::numbers::pi * t / std::max(o.duration, 1e-9);
  const double azimuth = -0.9 + 0.5 * o.span * std::sin(phase);
  const double r = f.radius * (1 + 0.06 * std::sin(2 * phase + 0.7)), h = f.height * (1 + 0.15 * std::sin(3 * phase));
  return look_at(f.focus + Vector3d(r * std::cos(azimuth), r * std::sin(azimuth), h), f.focus);
}

SE3 sweep_view(const Frame3& f, const PathOptions& o, double t) {
  const double share = 0.5 - 0.5 * std::cos(std::numbers::pi * std::min(1.0, t / std::max(o.duration, 1e-9)));
  const Vector3d offset(0.75 * o.span * (2 * share - 1), 0, 0);
  return look_at(f.focus + offset + Vector3d(0, -f.radius, f.height), f.focus + 0.8 * offset);
}

SE3 handheld_view(const Frame3& f, const PathOptions& o, double t) {
  const Tremor3 eye(stream(o.seed, 41), 0.05, 0.35), aim(stream(o.seed, 42), 0.08, 0.6);
  const Vector3d reach(0.18 * f.radius, 0.12 * f.radius, 0.12 * f.radius);
  const Vector3d home = f.focus + Vector3d(0.35 * f.radius, -0.9 * f.radius, f.height);
  return look_at(home + reach.cwiseProduct(eye.at(t)), f.focus + 0.16 * f.radius * aim.at(t));
}

SE3 turntable_view(const Frame3& f, const PathOptions& o, double t) {
  const double azimuth = 2 * std::numbers::pi * t / std::max(o.duration, 1e-9);
  return look_at(f.focus + Vector3d(f.radius * std::cos(azimuth), f.radius * std::sin(azimuth), f.height), f.focus);
}

/// Turned about all three axes from one place, as an orientation sensor is calibrated.
SE3 dance_view(const Frame3& f, const PathOptions& o, double t) {
  const Tremor3 eye(stream(o.seed, 46), 0.1, 0.4), turn(stream(o.seed, 47), 0.1, 0.3);
  const Vector3d home = f.focus + Vector3d(0.35 * f.radius, -0.9 * f.radius, f.height);
  const SE3 view = look_at(home + 0.03 * eye.at(t), f.focus);
  const Vector3d degrees = Vector3d(20, 25, 30).cwiseProduct(turn.at(t));
  const auto about = [&](int axis) { return so3::exp(degrees[axis] * std::numbers::pi / 180 * Vector3d::Unit(axis)); };
  return {view.rotation() * about(1) * about(0) * about(2), view.translation()};
}

/// A polyline on the floor, walked at a constant speed, its corners rounded.
class Way {
 public:
  explicit Way(std::vector<Vector2d> points) : points_(std::move(points)) {
    for (std::size_t i = 0; i < points_.size(); ++i)
      lengths_.push_back(i == 0 ? 0 : lengths_.back() + (points_[i] - points_[i - 1]).norm());
  }
  double length() const { return lengths_.back(); }  ///< metres

  /// Mean over half a metre to both sides.
  Vector2d at(double metres) const {
    constexpr int kSamples = 8;
    constexpr double kReach = 0.5;
    Vector2d sum = Vector2d::Zero();
    for (int i = -kSamples; i <= kSamples; ++i) sum += corner_at(metres + kReach * i / kSamples);
    return sum / (2 * kSamples + 1);
  }

 private:
  Vector2d corner_at(double metres) const {
    const double s = std::clamp(metres, 0.0, length());
    const auto next = std::upper_bound(lengths_.begin() + 1, lengths_.end() - 1, s);
    const auto i = static_cast<std::size_t>(next - lengths_.begin());
    const double share = (s - lengths_[i - 1]) / std::max(lengths_[i] - lengths_[i - 1], 1e-9);
    return points_[i - 1] + share * (points_[i] - points_[i - 1]);
  }

  std::vector<Vector2d> points_;
  std::vector<double> lengths_;
};

Way way_of(const Scene& scene, double radius) {
  if (scene.way.size() > 1) return Way(scene.way);
  const Vector2d middle = scene.focus.head<2>();
  std::vector<Vector2d> square;
  for (const Vector2d& corner : {Vector2d(-1, -1), Vector2d(1, -1), Vector2d(1, 1), Vector2d(-1, 1), Vector2d(-1, -1)})
    square.push_back(middle + radius * corner);
  return Way(square);
}

/// As one carries a camera along, looking ahead, to the sides and at the floor.
SE3 walk_view(const Way& way, const PathOptions& o, double t) {
  constexpr double kEyeHeight = 1.45, kAhead = 1.2;  // metres
  const Tremor look(stream(o.seed, 48), 0.06, 0.25), nod(stream(o.seed, 49), 0.05, 0.3);
  const double metres = way.length() * t / std::max(o.duration, 1e-9);
  const Vector2d eye = way.at(metres), ahead = way.at(metres + kAhead), behind = way.at(metres - 0.3);
  const Vector2d along = (ahead - behind).normalized();
  const double yaw = 0.22 * look.at(t), pitch = 0.22 + 0.1 * nod.at(t);
  const Vector2d turned(std::cos(yaw) * along.x() - std::sin(yaw) * along.y(),
                        std::sin(yaw) * along.x() + std::cos(yaw) * along.y());
  const Vector3d from(eye.x(), eye.y(), kEyeHeight);
  return look_at(from, from + Vector3d(turned.x(), turned.y(), -std::tan(pitch)));
}

struct Kind {
  const char* name;
  SE3 (*view)(const Frame3&, const PathOptions&, double);  ///< null: along the scene's way
  bool trembles;
};
constexpr std::array<Kind, 6> kKinds = {{{"orbit", &orbit_view, true},
                                         {"sweep", &sweep_view, true},
                                         {"handheld", &handheld_view, true},
                                         {"turntable", &turntable_view, false},
                                         {"dance", &dance_view, true},
                                         {"walk", nullptr, true}}};

}  // namespace

// ---- Motion

Motion::Motion(std::vector<SE3> controls, double interval) : controls_(std::move(controls)), interval_(interval) {
  if (controls_.size() < 2 || !(interval > 0))
    throw Error("a motion needs two poses and a positive interval", kTrajectoryWhere, "give a longer path");
  for (const SE3& pose : controls_)
    if (!pose.is_finite()) throw Error("a pose of the path is not finite", kTrajectoryWhere, "remove it");
  duration_ = interval_ * static_cast<double>(controls_.size() - 1);
}

namespace {

/// Of the cubic B-spline, 0 ≤ u ≤ 1 (Kim, Kim, Shin 1995).
std::array<double, 3> cumulative_basis(double u) {
  const double u2 = u * u, u3 = u2 * u;
  return {(5 + 3 * u - 3 * u2 + u3) / 6, (1 + 3 * u + 3 * u2 - 2 * u3) / 6, u3 / 6};
}

}  // namespace

SE3 Motion::at(double seconds) const {
  const double position = std::clamp(seconds, 0.0, duration_) / interval_;
  const auto last = static_cast<std::ptrdiff_t>(controls_.size()) - 1;
  const auto i = std::min(static_cast<std::ptrdiff_t>(position), last - 1);
  const auto control = [&](std::ptrdiff_t k) -> const SE3& {
    return controls_[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(k, 0, last))];
  };
  const std::array<double, 3> cumulative = cumulative_basis(position - static_cast<double>(i));
  Matrix3d rotation = control(i - 1).rotation();
  Vector3d translation = control(i - 1).translation();
  for (std::ptrdiff_t k = 0; k < 3; ++k) {
    const SE3 &a = control(i - 1 + k), &b = control(i + k);
    const double weight = cumulative[static_cast<std::size_t>(k)];
    rotation = rotation * so3::exp(weight * so3::log(a.rotation().transpose() * b.rotation()));
    translation += weight * (b.translation() - a.translation());
  }
  return SE3(rotation, translation).normalized();
}

Motion Motion::faster(double factor) const {
  if (!(factor > 0)) throw Error("the speed is not positive", kTrajectoryWhere, "give a factor such as 2");
  return {controls_, interval_ / factor};
}

Motion Motion::placed(const SE3& placed_from_world) const {
  std::vector<SE3> moved;
  moved.reserve(controls_.size());
  for (const SE3& pose : controls_) moved.push_back((placed_from_world * pose).normalized());
  return {std::move(moved), interval_};
}

Motion smooth_motion(const Trajectory& recorded, double window, Smoothing* lost) {
  constexpr std::size_t kMinSamples = 5;
  if (recorded.size() < kMinSamples)
    throw Error("has " + std::to_string(recorded.size()) + " poses, too few for a smooth path", kTrajectoryWhere,
                "give a trajectory of at least 5 poses");
  std::vector<Sample> samples;
  samples.reserve(recorded.size());
  for (const StampedPose& pose : recorded)
    samples.push_back({to_seconds(pose.time - recorded.front().time), pose.world_from_camera});
  const double duration = samples.back().t;
  const int intervals = std::max(1, static_cast<int>(std::lround(duration / kControlInterval)));
  std::vector<SE3> controls;
  for (int i = 0; i <= intervals; ++i) controls.push_back(regress(samples, duration * i / intervals, window));
  Motion motion(std::move(controls), duration / intervals);
  if (lost == nullptr) return motion;
  *lost = {};
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const SE3 pose = motion.at(samples[i].t);
    const double angle = so3::angle(pose.rotation().transpose() * samples[i].pose.rotation());
    lost->translation_rms += (pose.translation() - samples[i].pose.translation()).squaredNorm();
    lost->rotation_rms += angle * angle;
    if (i > 0) lost->longest_gap = std::max(lost->longest_gap, samples[i].t - samples[i - 1].t);
  }
  lost->translation_rms = std::sqrt(lost->translation_rms / static_cast<double>(samples.size()));
  lost->rotation_rms = std::sqrt(lost->rotation_rms / static_cast<double>(samples.size()));
  return motion;
}

std::vector<std::string> path_kinds() {
  std::vector<std::string> names;
  for (const Kind& kind : kKinds) names.emplace_back(kind.name);
  return names;
}

namespace {

/// With the tremor of the hand that carries it.
Motion held(const std::function<SE3(double)>& smooth, const PathOptions& options, double shake) {
  const Tremor3 move(stream(options.seed, 43), 0.4, 4.0), turn(stream(options.seed, 44), 0.4, 4.0);
  const int intervals = std::max(2, static_cast<int>(std::ceil(options.duration / kControlInterval)));
  std::vector<SE3> controls;
  for (int i = 0; i <= intervals; ++i) {
    const double t = options.duration * i / intervals;
    const SE3 view = smooth(t);
    controls.emplace_back(view.rotation() * so3::exp(0.005 * shake * turn.at(t) / std::sqrt(3.0)),
                          view.translation() + 0.004 * shake * move.at(t) / std::sqrt(3.0));
  }
  return {std::move(controls), options.duration / intervals};
}

}  // namespace

Motion make_path(const std::string& name, const Scene& scene, const PathOptions& options) {
  const auto* kind = std::find_if(kKinds.begin(), kKinds.end(), [&](const Kind& k) { return name == k.name; });
  if (kind == kKinds.end())
    throw Error("there is no path '" + name + "'", kTrajectoryWhere,
                "take orbit, sweep, handheld, turntable, dance, walk, or a TUM file");
  if (!(options.duration > 0)) throw Error("the duration is not positive", kTrajectoryWhere, "give seconds");
  Frame3 frame{scene.focus, options.radius, options.height};
  if (!(frame.radius > 0)) frame.radius = std::clamp(1.35 * scene.focus_radius, 0.3, 1.9);
  if (frame.height == 0) frame.height = 0.4 * frame.radius;
  const double shake = kind->trembles ? options.shake : 0;
  if (kind->view != nullptr) return held([&](double t) { return kind->view(frame, options, t); }, options, shake);
  constexpr double kMaxSpeed = 0.8;  // m/s
  const Way way = way_of(scene, frame.radius);
  PathOptions walk = options;
  walk.duration = std::max(options.duration, way.length() / kMaxSpeed);
  return held([&](double t) { return walk_view(way, walk, t); }, walk, shake);
}

// ---- TurnPairs

TurnPairs::TurnPairs(Motion path, double angle, TurnAxis axis, double rate, std::uint64_t seed)
    : path_(std::move(path)), angle_(angle), rate_(rate), axis_(axis), seed_(stream(seed, 45)) {
  if (!(rate > 0) || !std::isfinite(angle))
    throw Error("the turn or the rate is not a number", kTrajectoryWhere, "correct it");
}

Matrix3d TurnPairs::turn(int pair) const {
  const double draw = uniform_at(seed_, static_cast<std::uint64_t>(pair)), azimuth = 2 * std::numbers::pi * draw;
  if (axis_ == TurnAxis::pan) return so3::exp((draw < 0.5 ? angle_ : -angle_) * Vector3d::UnitY());
  return so3::exp(angle_ * Vector3d(std::cos(azimuth), std::sin(azimuth), 0));
}

/// Between frames the camera goes on smoothly, standing still at each, so that a sensor sees a motion that can be.
SE3 TurnPairs::at(double seconds) const {
  const double frame = std::max(0.0, seconds * rate_);
  const int pair = static_cast<int>(frame / 2);
  const double within = frame - 2 * pair, step = within < 1 ? within : within - 1;
  const double share = step * step * step * (10 + step * (6 * step - 15));
  const SE3 view = path_.at(2 * pair / rate_), next = path_.at(2 * (pair + 1) / rate_);
  const Matrix3d full = turn(pair);
  if (within < 1) return {view.rotation() * so3::exp(share * so3::log(full)), view.translation()};
  const Matrix3d turned = view.rotation() * full;
  return {turned * so3::exp(share * so3::log(turned.transpose() * next.rotation())),
          view.translation() + share * (next.translation() - view.translation())};
}

}  // namespace plumbline::sim
