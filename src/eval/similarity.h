// The scale of a path that does not know its own, as a single camera's.
#pragma once

#include <optional>

#include "plumbline/evaluation.h"

namespace plumbline::eval {

/// The factor of the similarity that brings the estimate's positions onto the reference's with the least squares
/// (Umeyama 1991, eq. 42); its rotation is that of the rigid alignment. 1 for an estimate that does not move. Throws
/// Error where fewer than 3 poses can be associated.
double similarity_scale(const Trajectory& reference, const Trajectory& estimate,
                        const AssociationOptions& options = {});

/// The trajectory with its positions multiplied.
Trajectory scaled(Trajectory trajectory, double scale);

/// Whether the estimate would fit if its poses were inverted (camera_from_world, where world_from_camera is meant): to
/// a fifth of its error at most, which is returned, metres; else empty. Throws Error as above.
std::optional<double> error_if_inverted(const Trajectory& reference, const Trajectory& estimate,
                                        const AssociationOptions& options = {});

}  // namespace plumbline::eval
