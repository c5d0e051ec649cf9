// Whether what a sequence says of itself adds up.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "plumbline/pinhole.h"
#include "plumbline/sequence.h"

namespace plumbline {

/// Depth of about a dozen frames. Metres are those of the sequence's scale.
struct DepthFigures {
  int frames = 0;
  double share = 0;                      ///< of the pixels that have a reading
  double near = 0, median = 0, far = 0;  ///< quantiles 5 %, 50 % and 95 %, metres
  int step = 0;                          ///< all readings are multiples of it
  int end = 0;                           ///< the largest reading below 65535
  double end_share = 0;                  ///< of the readings have that value; from 0.15 on the quantiles leave it out
  bool stretched = false;                ///< every image reaches up to 65535, with readings all the way
};
DepthFigures depth_figures(const Sequence& sequence);

/// Scales that would put the readings where a depth camera sees something, the likeliest first.
std::vector<double> plausible_scales(const DepthFigures& figures, double depth_scale);

/// In words, if the numbers make more sense in another order, such as fx, cx, fy, cy.
std::optional<std::string> other_order(const Pinhole& camera);

/// The median of the intervals between ascending stamps; 0 for fewer than two.
Nanoseconds usual_interval(const std::vector<Nanoseconds>& times);

/// A gap beyond this is a jump: a second, and fifteen of the usual intervals.
Nanoseconds jump_limit(const std::vector<Nanoseconds>& times);

/// What does not add up in depth, scale, camera and stamps. Frames that cannot be read say nothing here.
std::vector<Warning> check_plausibility(const Sequence& sequence);

}  // namespace plumbline
