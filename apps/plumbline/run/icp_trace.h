// The iterations of one frame as JSON: what the plots of distance distributions and convergence are drawn from.
#pragma once

#include <string>
#include <vector>

#include "plumbline/parameters.h"
#include "plumbline/pipeline.h"

namespace plumbline::app {

/// Histogram, median, matched fraction, λ, step and residual of every iteration at every level, coarse to fine.
std::string icp_json(const FrameReport& report, const std::vector<IcpIteration>& iterations,
                     const Parameters& parameters);

}  // namespace plumbline::app
