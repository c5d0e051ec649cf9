// Whether an orientation turns as the camera does, and if not, what it would have to mean to do so.
//
// Frames: E earth (x east, y north, z up), B the sensor's body, C the camera. With M = body_from_camera the turn of the
// camera between two frames, a = log(first_from_second), is Mᵀ b, b being that of the body: a wrong mounting is one
// rotation between two bundles of vectors.
//
// What turns cannot tell: a rotation on the left of all orientations (wrong earth axes) drops out. And a quaternion
// whose components are read in the wrong cyclic order is p q* r with two fixed unit quaternions (a cyclic permutation
// of four is an odd one, so a reflection of the four-dimensional space), hence the inverse in other earth axes with
// another mounting: with a mounting to be found, hypotheses come in pairs that fit alike.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "plumbline/orientation.h"

namespace plumbline {

/// Two frames that were tracked, and the stream's readings at their times.
struct TurnPair {
  Eigen::Matrix3d first_from_second;       ///< of the camera, as tracked
  Eigen::Matrix3d earth_from_body_first;   ///< as read with the declared convention
  Eigen::Matrix3d earth_from_body_second;  ///< as read with the declared convention
};

struct ConventionFit {
  OrientationConvention convention;
  Eigen::Matrix3d body_from_camera = Eigen::Matrix3d::Identity();
  bool mounting_fitted = false;
  double residual = 0;  ///< radians rms over the pairs
};

enum class ConventionVerdict {
  too_little_motion,  ///< nothing can be said
  fits,               ///< as declared, and nothing else clearly better
  another_fits,       ///< `best` says what
  none_fits
};

struct ConventionCheck {
  ConventionVerdict verdict = ConventionVerdict::too_little_motion;
  /// As declared; world-to-body for body-to-world or the reverse; the other quaternion order; both. Then, where the
  /// camera turned about two axes, the same with the mounting that fits best.
  std::vector<ConventionFit> fits;
  std::size_t best = 0;        ///< index of the simplest that no other clearly beats
  double camera_turn = 0;      ///< radians rms over the pairs
  double body_turn = 0;        ///< the same of the sensor
  bool two_axes = false;       ///< the camera turned about more than one axis, so that a mounting can be found
  bool mirrored_fits = false;  ///< a mirrored mounting fits clearly better than any: axes swapped or left-handed
  std::string message;         ///< plain words for the user, with the options to give
};

/// Pairs should be some degrees of turning apart; ten at least with 2° rms are asked for. Never throws.
ConventionCheck check_convention(const std::vector<TurnPair>& pairs, const OrientationConvention& declared,
                                 const Eigen::Matrix3d& body_from_camera);

}  // namespace plumbline
