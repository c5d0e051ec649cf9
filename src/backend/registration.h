// A frame's registration driven by the host, pass by pass.
#pragma once

#include <functional>

#include "backend/backend.h"
#include "kernels/registration.h"
#include "plumbline/se3.h"

namespace plumbline {

/// Told after each iteration: the state, the sums of its pass, and the level (of the registration's).
using IterationObserver = std::function<void(const kernels::RegistrationState&, const IcpSums&, int)>;

/// Sums up what `kernels::advance` asks for until nothing is left.
kernels::RegistrationState run_passes(const Backend& backend, const kernels::Registration& registration,
                                      const SE3& model_from_live, const IterationObserver& observe = {});

}  // namespace plumbline
