// Pairs of frames between which the camera turned by a given angle, for the angular test.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "plumbline/angles.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"

namespace plumbline::eval {

/// world_from_camera at a time: that of a pose with this stamp (within 10 µs, for stamps were rounded), or at constant
/// velocity between two poses at most 0.1 s apart; empty elsewhere. O(log n).
std::optional<SE3> pose_at(const Trajectory& trajectory, Nanoseconds time);

struct TurnedPairOptions {
  double angle = 0;               ///< radians
  double tolerance = radians(1);  ///< radians, either way
  double max_translation = 0.25;  ///< metres
  std::size_t count = 20;
};

struct TurnedPair {
  std::size_t first = 0, second = 0;  ///< indices of frames, first < second
  double angle = 0;                   ///< radians
  double translation = 0;             ///< metres
};

/// At most `count` pairs, ordered by their first frames, each with another first frame. Frames without a pose are
/// passed over.
///
/// A frame's partner is, of the later frames within the options' bounds, the one with the smallest translation (then
/// with the angle nearest to the requested one, then the earliest). The frames are divided into `count` stretches of
/// equal length, and each stretch gives its best pair by the same order; while pairs are wanting, those stretches that
/// have more give their next best, and where they offer more than are wanted the best of these are taken. O(n²), where
/// most of the n² are left at the first look at their distance.
std::vector<TurnedPair> turned_pairs(const std::vector<std::optional<SE3>>& world_from_camera,
                                     const TurnedPairOptions& options);

}  // namespace plumbline::eval
