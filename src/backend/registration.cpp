#include "backend/registration.h"
#include "plumbline/se3.h"

#include <numeric>

namespace plumbline {

kernels::RegistrationState run_passes(const Backend& backend, const kernels::Registration& registration,
                                      const SE3& model_from_live, const IterationObserver& observe) {
  using kernels::RegistrationTask;
  kernels::RegistrationState state = kernels::begin(registration, model_from_live);
  IcpSums pass;
  int made = 0;
  while (state.next.task != RegistrationTask::finished) {
    const int level = state.next.level;
    const PlaneView<float>& distances = registration.levels[level].distances;
    if (state.next.task == RegistrationTask::correction) {
      const PlaneView<const float> kept{distances.data, distances.width, distances.height, distances.stride};
      IcpSums changes;
      backend.correct({state.next.in, state.next.from_low, state.next.from_high, kept}, &changes);
      kernels::advance(registration, changes.slots, -1, &state);
    } else {
      pass = backend.reduce({state.next.in, distances});
      kernels::advance(registration, pass.slots, pass.median_bin(), &state);
    }
    const int now = std::accumulate(std::begin(state.iterations), std::end(state.iterations), 0);
    if (observe && now > made) observe(state, pass, level);
    made = now;
  }
  return state;
}

}  // namespace plumbline
