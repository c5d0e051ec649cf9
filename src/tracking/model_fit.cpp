#include "tracking/model_fit.h"

#include <algorithm>
#include <cmath>

namespace plumbline {

void ModelFit::observe(double rms, double seconds) {
  constexpr double kMemory = 0.3;  // seconds
  const double square = rms * rms;
  square_ = square + std::exp(-seconds / kMemory) * (square_ - square);
}

double ModelFit::repeated_share() const { return std::clamp(square_ / (kNoise * kNoise) - 1, 0.0, 1.0); }

}  // namespace plumbline
