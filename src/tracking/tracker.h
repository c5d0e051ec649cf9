// Frame-to-model registration, coarse to fine: from a seed to a pose, and why it is believed.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "backend/maps.h"
#include "kernels/registration.h"
#include "plumbline/parameters.h"
#include "plumbline/se3.h"
#include "plumbline/tracking.h"
#include "tracking/priors.h"

namespace plumbline {

/// What the tracker starts from. The default is the plain KinectFusion of METHOD.md §1.
struct TrackingInput {
  SE3 world_from_model;                        ///< camera pose from which the model was predicted
  SE3 world_from_camera_seed;                  ///< initial guess
  kernels::Priors priors;                      ///< what is known besides; none: registration alone
  std::vector<IcpIteration>* trace = nullptr;  ///< if given, gets every iteration
};

/// Levels of both pyramids needed: finest_level + number of entries of iterations.
int pyramid_levels(const TrackingParameters& parameters);

/// What the parameters ask of every pass and step.
kernels::RegistrationRules registration_rules(const TrackingParameters& parameters);

/// Registers `live` against `model` (METHOD.md §1, "association" and "minimisation"; §3 and §4). The model's
/// pyramid may lack the finest levels, which are not registered.
TrackingResult track(const Backend& backend, const DepthPyramid& live, const DepthPyramid& model,
                     const TrackingInput& input, const TrackingParameters& parameters);

}  // namespace plumbline
