// Where ICP may start from when the expected pose may lie outside of what it converges from: several starts are
// registered coarsely, and the one that explains most is taken.
#pragma once

#include <vector>

#include "plumbline/parameters.h"
#include "plumbline/se3.h"
#include "tracking/registration.h"

namespace plumbline {

/// How well a registration explains what two images have in common, as a part of the live one's readings: to choose
/// between several by. What meets the model and does not match speaks against it, else the one with the largest overlap
/// would be the best.
double agreement(const TrackingResult& result);

/// Whether it is lost or explains so little, and so much less than that of the last accepted frame did, that another
/// start may well lead to a better one.
bool is_doubtful(const TrackingResult& result, double previous_agreement);

/// Turns of a camera about `seed`: about eight axes across the line of sight, by one, two and three times `step`
/// radians.
std::vector<SE3> turned_about(const SE3& seed, double step);

/// The parameters without the finest level, where most of the time goes: as good for choosing where to start.
TrackingParameters coarse(TrackingParameters parameters);

/// A registration that is not judged by how far it went: what was found is judged by what is seen there.
TrackingParameters without_limits(TrackingParameters parameters);

/// Of the `levels` coarsest levels alone, with gates that let in what is half a metre and 40° away.
TrackingParameters far_reaching(const TrackingParameters& parameters, int levels);

/// With more and smaller steps, for images that have little in common: they hold some directions so weakly that ICP
/// comes near the minimum but slowly.
TrackingParameters patient(TrackingParameters parameters);

}  // namespace plumbline
