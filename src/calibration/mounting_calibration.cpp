#include "calibration/mounting_calibration.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "calibration/calibration_text.h"
#include "calibration/hand_eye.h"
#include "calibration/joint_refinement.h"
#include "calibration/time_offset.h"
#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"

namespace plumbline {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Turns for the closed forms: as short as possible, for what drifts, and as long as it takes to stand out of the noise.
constexpr double kTurn = radians(20), kMinTurn = radians(5), kMaxTurnSeconds = 1.5;  // the last in seconds
constexpr std::size_t kMaxTurns = 500, kMinTurns = 3;

constexpr std::size_t kMinFrames = 30, kMaxFrames = 1500;
constexpr double kMinDuration = 2;         // seconds
constexpr double kMargin = 0.03;           // seconds of readings around a frame, for the offset to move in
constexpr double kMinSpread = radians(5);  // rms about each of two axes; a hand that holds still has one or two
constexpr double kMinCorrelation = 0.6;    // of angular speeds
constexpr double kMaxResidual = radians(5);

/// The frames that have a reading at an offset, and a little around.
Trajectory frames_with_reading(const Trajectory& camera, const OrientationStream& sensor, double offset) {
  Trajectory frames;
  for (const StampedPose& frame : camera) {
    const auto has = [&](double seconds) {
      return sensor.lookup(frame.time - from_seconds(offset) + from_seconds(seconds)).status == OrientationStatus::ok;
    };
    if (has(-kMargin) && has(0) && has(kMargin)) frames.push_back(frame);
  }
  return frames;
}

Trajectory thinned(const Trajectory& frames) {
  const std::size_t stride = (frames.size() + kMaxFrames - 1) / kMaxFrames;
  if (stride <= 1) return frames;
  Trajectory some;
  for (std::size_t i = 0; i < frames.size(); i += stride) some.push_back(frames[i]);
  return some;
}

/// From each frame the shortest turn that is large enough, or else the largest within the time.
Matrix3d turn_between(const StampedPose& from, const StampedPose& to) {
  return from.world_from_camera.rotation().transpose() * to.world_from_camera.rotation();
}

/// The frame up to which the camera turned far enough since frame `begin`, or else farthest.
std::size_t end_of_turn(const Trajectory& frames, std::size_t begin) {
  std::size_t best = begin;
  double angle = 0;
  for (std::size_t j = begin + 1; j < frames.size() && angle < kTurn; ++j) {
    if (to_seconds(frames[j].time - frames[begin].time) > kMaxTurnSeconds) break;
    const double turned = so3::angle(turn_between(frames[begin], frames[j]));
    if (turned > angle) best = j, angle = turned;
  }
  return best;
}

Turns choose_turns(const Trajectory& frames, const OrientationStream& sensor, double offset) {
  Turns turns;
  const auto body = [&](std::size_t i) { return sensor.lookup(frames[i].time - from_seconds(offset)).earth_from_body; };
  const std::size_t stride = std::max<std::size_t>(1, frames.size() / kMaxTurns);
  for (std::size_t i = 0; i < frames.size(); i += stride) {
    const std::size_t end = end_of_turn(frames, i);
    const Matrix3d turn = turn_between(frames[i], frames[end]);
    if (so3::angle(turn) < kMinTurn) continue;
    turns.camera.push_back(so3::log(turn));
    turns.body.push_back(so3::log(body(i).transpose() * body(end)));
  }
  return turns;
}

/// Root mean square of the angular rate over five frames, radians a second.
double turning_speed(const Trajectory& frames) {
  double speeds = 0;
  for (std::size_t i = 0; i + 5 < frames.size(); ++i) {
    const StampedPose &from = frames[i], &to = frames[i + 5];
    const double speed = so3::angle(turn_between(from, to)) / to_seconds(to.time - from.time);
    speeds += speed * speed / static_cast<double>(frames.size() - 5);
  }
  return std::sqrt(speeds);
}

/// How far the camera turned about which of its axes, and how fast.
void measure_motion(const Trajectory& frames, MountingCalibration* out) {
  Matrix3d sum = Matrix3d::Zero(), moments = Matrix3d::Zero();
  for (const StampedPose& frame : frames) sum += frame.world_from_camera.rotation();
  const Matrix3d mean = nearest_rotation(sum);
  for (const StampedPose& frame : frames) {
    const Vector3d turn = so3::log(mean.transpose() * frame.world_from_camera.rotation());
    moments += turn * turn.transpose() / static_cast<double>(frames.size());
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(moments);  // ascending
  out->spread = solver.eigenvalues().reverse().cwiseMax(0).cwiseSqrt();
  out->spread_axes = solver.eigenvectors().rowwise().reverse();
  out->speed = turning_speed(frames);
  out->duration = to_seconds(frames.back().time - frames.front().time);
}

/// Closed forms and refinement at one candidate of the offset.
std::optional<MountingCalibration> calibrate_at(const Trajectory& camera, const OrientationStream& sensor,
                                                const OffsetCandidate& candidate) {
  MountingCalibration out;
  const Trajectory all = frames_with_reading(camera, sensor, candidate.offset);
  if (all.empty()) return std::nullopt;
  out.frames = all.size();
  out.first_offset = out.time_offset = candidate.offset;
  out.correlation = candidate.correlation;
  measure_motion(all, &out);
  const Turns turns = choose_turns(all, sensor, candidate.offset);
  out.turns = turns.camera.size();
  out.covariance = Matrix3d::Identity() * std::numbers::pi * std::numbers::pi;
  out.time_offset_sd = 1;
  if (out.turns < kMinTurns || all.size() < kMinFrames || !(out.duration > 0)) return out;
  out.tsai_lenz = tsai_lenz(turns);
  out.park_martin = fit_mounting(turns).proper;
  out.tsai_lenz_residual = turn_residual(turns, out.tsai_lenz);
  out.park_martin_residual = turn_residual(turns, out.park_martin);
  const JointEstimate joint = refine_jointly(thinned(all), sensor, out.park_martin, candidate.offset);
  out.body_from_camera = joint.body_from_camera;
  out.covariance = joint.body_from_camera.transpose() * joint.covariance * joint.body_from_camera;
  out.time_offset = joint.time_offset;
  out.time_offset_sd = joint.time_offset_sd;
  out.residual = joint.residual;
  out.redundancy = joint.redundancy;
  out.drift = joint.drift;
  out.systematic = joint.systematic;
  return out;
}

constexpr const char* kDance =
    "Hold the camera where it sees a room full of things, and turn it in about ten seconds by 40° or more each way: "
    "left and right, up and down, and about its line of sight";

/// Verdict and what to do, from the figures.
void judge(const MountingOptions& options, MountingCalibration* c) {
  const auto say = [&](MotionVerdict verdict, std::string advice) {
    c->verdict = verdict;
    c->advice = std::move(advice);
  };
  if (c->frames < kMinFrames || c->duration < kMinDuration)
    return say(MotionVerdict::too_short, fmt::format("only {} frames over {:.1f} s have a pose and a reading. {}.",
                                                     c->frames, c->duration, kDance));
  if (c->spread[0] < kMinSpread || c->turns < kMinTurns)
    return say(MotionVerdict::no_rotation,
               fmt::format("the camera hardly turned ({} rms). {}.", degrees_text(c->spread[0]), kDance));
  if (c->spread[1] < kMinSpread)
    return say(
        MotionVerdict::one_axis,
        fmt::format("the camera turned about one axis only: {} rms about {}, {} about any other, which leaves the "
                    "mounting about that axis open. {}.",
                    degrees_text(c->spread[0]), axis_text(c->spread_axes.col(0)), degrees_text(c->spread[1]), kDance));
  if (c->correlation < kMinCorrelation || c->residual > kMaxResidual)
    return say(
        MotionVerdict::does_not_fit,
        fmt::format("the sensor does not turn as the camera does (correlation of the speeds {:.2f}, residual {}). "
                    "Check that both are of the same recording, and what the numbers mean (--quaternion, "
                    "--orientation-of); if the clocks differ by more than the search covers, give --search.",
                    c->correlation, degrees_text(c->residual)));
  const Vector3d sd = c->sd_along();
  if (!(sd[2] <= options.worst_mounting))
    return say(
        MotionVerdict::mounting_unsure,
        fmt::format("the mounting about the camera's axis {} is known to ±{} only (one standard deviation). Turn "
                    "farther, and about axes across that one. {}.",
                    axis_text(c->worst_axis()), degrees_text(sd[2]), kDance));
  if (!(c->time_offset_sd <= options.worst_offset))
    return say(MotionVerdict::offset_unsure,
               fmt::format("the time offset is known to ±{:.1f} ms only: the camera turned too slowly ({}/s rms). Turn "
                           "faster, with quick starts and stops.",
                           1e3 * c->time_offset_sd, degrees_text(c->speed)));
  say(MotionVerdict::good, "");
}

}  // namespace

std::string_view to_string(MotionVerdict verdict) {
  switch (verdict) {
    case MotionVerdict::good:
      return "good";
    case MotionVerdict::too_short:
      return "too short";
    case MotionVerdict::no_rotation:
      return "no rotation";
    case MotionVerdict::one_axis:
      return "one axis only";
    case MotionVerdict::does_not_fit:
      return "does not fit";
    case MotionVerdict::mounting_unsure:
      return "mounting unsure";
    case MotionVerdict::offset_unsure:
      return "time offset unsure";
  }
  return "unknown";
}

Vector3d MountingCalibration::sd_along() const {
  return Eigen::SelfAdjointEigenSolver<Matrix3d>(covariance).eigenvalues().cwiseMax(0).cwiseSqrt();
}

Vector3d MountingCalibration::worst_axis() const {
  return Eigen::SelfAdjointEigenSolver<Matrix3d>(covariance).eigenvectors().col(2);
}

std::string axis_text(const Vector3d& axis) {
  constexpr std::array<const char*, 3> kNames = {"x (up and down)", "y (left and right)", "z (its line of sight)"};
  Eigen::Index largest = 0;
  if (axis.cwiseAbs().maxCoeff(&largest) > 0.9 * axis.norm()) return kNames[static_cast<std::size_t>(largest)];
  const Vector3d shown = axis[largest] < 0 ? Vector3d(-axis) : axis;
  return fmt::format("({:.2f}, {:.2f}, {:.2f})", shown.x(), shown.y(), shown.z());
}

MountingCalibration calibrate_mounting(const Trajectory& camera, const OrientationStream& sensor,
                                       const MountingOptions& options) {
  std::vector<OffsetCandidate> candidates = correlate_angular_speed(camera, sensor, options.search);
  if (candidates.empty()) candidates.push_back({});  // too little motion to tell; it is judged below
  std::optional<MountingCalibration> best;
  for (const OffsetCandidate& candidate : candidates) {
    const std::optional<MountingCalibration> found = calibrate_at(camera, sensor, candidate);
    if (found && (!best || found->residual < best->residual)) best = found;
  }
  if (!best)
    throw Error("the sensor has no readings at the times of the camera's frames", "calibration",
                "Check that both are of the same recording and use the same clock.");
  judge(options, &*best);
  return *best;
}

MountingCalibration calibrate_mounting(const Trajectory& camera, const std::vector<OrientationSample>& samples,
                                       const MountingOptions& options) {
  return calibrate_mounting(camera, OrientationStream(samples, {}), options);
}

}  // namespace plumbline
