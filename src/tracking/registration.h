// Frame-to-model registration, coarse to fine: from a seed to a pose, and why it is accepted.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "backend/maps.h"
#include "kernels/registration.h"
#include "plumbline/image.h"
#include "plumbline/parameters.h"
#include "plumbline/se3.h"
#include "plumbline/tracking.h"
#include "tracking/terms.h"

namespace plumbline {

/// What a registration starts from. The default is the plain KinectFusion of docs/method.md §1.
struct RegistrationInput {
  SE3 world_from_model;                        ///< camera pose from which the model was predicted
  SE3 world_from_camera_seed;                  ///< initial guess
  kernels::Terms terms;                        ///< what is known besides; none: the images alone
  std::vector<IcpIteration>* trace = nullptr;  ///< if given, gets every iteration
};

/// Levels of both pyramids needed: finest_level + number of entries of iterations.
int pyramid_levels(const TrackingParameters& parameters);

/// What the parameters ask of every pass and step.
kernels::RegistrationRules registration_rules(const TrackingParameters& parameters);

/// Registers `live` against `model` (docs/method.md §1, "association" and "minimisation"; §3 and §4). The model's
/// pyramid may lack the finest levels, which are not registered.
TrackingResult register_frame(const Backend& backend, const DepthPyramid& live, const DepthPyramid& model,
                              const RegistrationInput& input, const TrackingParameters& parameters);

/// Why each pixel of the finest registered level was or was not used at a registration's estimate
/// (`kernels::PixelUse`).
Image<std::uint8_t> explain_pixels(const Backend& backend, const DepthPyramid& live, const DepthPyramid& model,
                                   const SE3& world_from_model, const TrackingResult& result,
                                   const TrackingParameters& parameters);

}  // namespace plumbline
