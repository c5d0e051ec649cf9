#include "calibration/convention_check.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/calibration_text.h"
#include "calibration/hand_eye.h"
#include "plumbline/angles.h"
#include "plumbline/se3.h"

namespace plumbline {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A tracker errs by a few tenths of a degree between two frames. With these, and ten pairs, that is no matter, and
// vectors at random have no mounting that seems to fit (three parameters against thirty numbers).
constexpr std::size_t kMinTurnPairs = 10;
constexpr double kMinCameraTurn = radians(2);  // rms
constexpr double kMinSecondAxis = radians(1);  // rms: three times the tracker's error

// A residual beside the camera's turn: 1 if the sensor stands still, about √2 if it turns at random. A smooth periodic
// error of n harmonics and amplitude A has a slope of at most n A (Bernstein), 0.52 for 10° and three of them: a
// declared convention whose chip errs like that must pass.
constexpr double kFits = 0.6;
// One hypothesis beats another that fits by a third of its residual and what a tracker errs by; one that does not fit,
// by half.
constexpr double kBetterThanGood = 1.0 / 3, kBetterThanBad = 0.5;
constexpr double kMinGain = radians(0.5), kMinGainOfTurn = 0.1;

double rms(const std::vector<Vector3d>& vectors) {
  double sum = 0;
  for (const Vector3d& v : vectors) sum += v.squaredNorm();
  return vectors.empty() ? 0 : std::sqrt(sum / static_cast<double>(vectors.size()));
}

Matrix3d reread(const Matrix3d& earth_from_body, const OrientationConvention& from, const OrientationConvention& to) {
  return decode_orientation(encode_orientation(earth_from_body, from), to);
}

Turns turns_of(const std::vector<TurnPair>& pairs, const OrientationConvention& declared,
               const OrientationConvention& hypothesis) {
  Turns turns;
  for (const TurnPair& pair : pairs) {
    const Matrix3d first = reread(pair.earth_from_body_first, declared, hypothesis),
                   second = reread(pair.earth_from_body_second, declared, hypothesis);
    turns.camera.push_back(so3::log(pair.first_from_second));
    turns.body.push_back(so3::log(first.transpose() * second));
  }
  return turns;
}

/// How much the camera turned about its second axis, radians rms.
double second_axis(const std::vector<Vector3d>& turns) {
  Matrix3d moments = Matrix3d::Zero();
  for (const Vector3d& a : turns) moments += a * a.transpose() / static_cast<double>(turns.size());
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(moments, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()[1]));  // ascending
}

std::vector<OrientationConvention> hypotheses(const OrientationConvention& declared) {
  std::vector<OrientationConvention> all;
  for (int i = 0; i < 4; ++i) {
    OrientationConvention h = declared;
    h.quaternion = declared.quaternion.value_or(QuaternionOrder::xyzw);
    if ((i & 1) != 0)
      h.orientation_of = h.orientation_of == OrientationOf::body_to_world ? OrientationOf::world_to_body
                                                                          : OrientationOf::body_to_world;
    if ((i & 2) != 0)
      h.quaternion = *h.quaternion == QuaternionOrder::xyzw ? QuaternionOrder::wxyz : QuaternionOrder::xyzw;
    all.push_back(h);
  }
  return all;
}

/// Whether one residual is so much less than another that it is no chance.
bool beats(double residual, double other, double turn) {
  const double share = other < kFits * turn ? kBetterThanGood : kBetterThanBad;
  return residual < share * other && other - residual > std::max(kMinGain, kMinGainOfTurn * turn);
}

/// The simplest hypothesis, by their order, that none after it clearly beats.
std::size_t choose(const std::vector<ConventionFit>& fits, double turn) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < fits.size(); ++i)
    if (beats(fits[i].residual, fits[best].residual, turn)) best = i;
  return best;
}

std::string mounting_text(const Matrix3d& body_from_camera) {
  Eigen::Quaterniond q(body_from_camera);
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const Eigen::Vector4d shown = (q.coeffs().array().abs() < 5e-5).select(0, q.coeffs());  // no "-0.0000"
  return fmt::format("{:.4f} {:.4f} {:.4f} {:.4f}", shown[0], shown[1], shown[2], shown[3]);
}

/// The options that turn what was declared into this.
std::string options_text(const ConventionFit& fit, const ConventionFit& declared) {
  std::string text;
  const auto add = [&](const std::string& option) { text += (text.empty() ? "" : " ") + option; };
  if (fit.convention.orientation_of != declared.convention.orientation_of)
    add(fmt::format("--orientation-of {}", name_of(fit.convention.orientation_of)));
  if (fit.convention.quaternion != declared.convention.quaternion)
    add(fmt::format("--quaternion {}", name_of(*fit.convention.quaternion)));
  if (fit.mounting_fitted) add(fmt::format("--mounting \"{}\"", mounting_text(fit.body_from_camera)));
  return text;
}

std::string another_text(const ConventionCheck& check) {
  const ConventionFit& declared = check.fits.front();
  const ConventionFit& best = check.fits[check.best];
  std::string text =
      fmt::format("the orientation fits with {}: {} instead of {} as declared", options_text(best, declared),
                  degrees_text(best.residual), degrees_text(declared.residual));
  // See the head of convention_check.h: inverse and order change together.
  if (best.mounting_fitted)
    text += fmt::format("; {} fits as well", options_text(check.fits[4 + ((check.best - 4) ^ 3U)], declared));
  return text;
}

double best_residual(const ConventionCheck& check) {
  return std::min_element(check.fits.begin(), check.fits.end(),
                          [](const auto& a, const auto& b) { return a.residual < b.residual; })
      ->residual;
}

std::string none_text(const ConventionCheck& check) {
  const std::string_view start = "the orientation does not turn as the camera does";
  if (check.body_turn < 0.1 * check.camera_turn)
    return fmt::format(
        "{}: it stands still ({} rms) where the camera turns by {} rms; check that the file belongs to "
        "this sequence",
        start, degrees_text(check.body_turn), degrees_text(check.camera_turn));
  std::string text = fmt::format("{}: {} off as declared", start, degrees_text(check.fits.front().residual));
  text += fmt::format(", {} at best, where the camera turns by {} rms; ", degrees_text(best_residual(check)),
                      degrees_text(check.camera_turn));
  if (check.mirrored_fits) return text + "it would fit mirrored: two of its axes are swapped, or they are left-handed";
  if (!check.two_axes)
    return text +
           "the camera turned about one axis only, so no mounting can be found: turn about a second one, or give "
           "--mounting";
  return text + "check that the file belongs to this sequence, and --orientation-offset";
}

std::string message_of(const ConventionCheck& check) {
  switch (check.verdict) {
    case ConventionVerdict::too_little_motion:
      return fmt::format("the camera turned too little to judge the orientation's convention ({} rms)",
                         degrees_text(check.camera_turn));
    case ConventionVerdict::fits:
      return fmt::format("the orientation fits as declared: {} rms where the camera turns by {}",
                         degrees_text(check.fits.front().residual), degrees_text(check.camera_turn));
    case ConventionVerdict::another_fits:
      return another_text(check);
    case ConventionVerdict::none_fits:
      return none_text(check);
  }
  return {};
}

ConventionVerdict judge(const ConventionCheck& check, std::size_t pairs) {
  if (pairs < kMinTurnPairs || !(check.camera_turn >= kMinCameraTurn)) return ConventionVerdict::too_little_motion;
  if (check.mirrored_fits || !(check.fits[check.best].residual < kFits * check.camera_turn))
    return ConventionVerdict::none_fits;
  return check.best == 0 ? ConventionVerdict::fits : ConventionVerdict::another_fits;
}

}  // namespace

ConventionCheck check_convention(const std::vector<TurnPair>& pairs, const OrientationConvention& declared,
                                 const Matrix3d& body_from_camera) {
  ConventionCheck check;
  std::vector<ConventionFit> fitted;
  double mirrored = std::numeric_limits<double>::infinity();
  for (const OrientationConvention& hypothesis : hypotheses(declared)) {
    const Turns turns = turns_of(pairs, declared, hypothesis);
    const MountingFit mounting = fit_mounting(turns);
    if (check.fits.empty()) {
      check.camera_turn = rms(turns.camera);
      check.body_turn = rms(turns.body);
      check.two_axes = !pairs.empty() && second_axis(turns.camera) >= kMinSecondAxis;
    }
    check.fits.push_back({hypothesis, body_from_camera, false, turn_residual(turns, body_from_camera)});
    fitted.push_back({hypothesis, mounting.proper, true, turn_residual(turns, mounting.proper)});
    mirrored = std::min(mirrored, turn_residual(turns, mounting.mirrored));
  }
  if (check.two_axes) check.fits.insert(check.fits.end(), fitted.begin(), fitted.end());
  check.best = choose(check.fits, check.camera_turn);
  // The inverse about a nearly constant attitude looks like a mirrored mounting, so the better of the two decides.
  check.mirrored_fits = check.two_axes && mirrored < kFits * check.camera_turn &&
                        beats(mirrored, check.fits[check.best].residual, check.camera_turn);
  check.verdict = judge(check, pairs.size());
  check.message = message_of(check);
  return check;
}

}  // namespace plumbline
