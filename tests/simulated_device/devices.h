// The devices that the tests go through: numbers of processors, generations and seeds.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "simulated_device/device.h"

namespace plumbline::test {

constexpr int kSeeds = 20;

inline simulated::Model device_with(int seed) {
  static constexpr int kProcessors[] = {1, 2, 7, 132};
  simulated::Model model;
  model.processors = kProcessors[seed % 4];
  model.capability = simulated::known_limits()[static_cast<std::size_t>(seed / 4) % 4].capability;
  model.seed = static_cast<std::uint64_t>(seed);
  return model;
}

inline std::string words(const simulated::Model& model) {
  return "seed " + std::to_string(model.seed) + ", " + std::to_string(model.processors) + " processors of sm_" +
         std::to_string(model.capability);
}

/// Plugs one device after the other in, does the work with each, and fails of what it finds wrong; the first failure
/// ends it.
template <class Work>
void on_devices(int first, int step, const Work& work) {
  for (int seed = first; seed < first + kSeeds && !testing::Test::HasFailure(); seed += step) {
    const simulated::Model model = device_with(seed);
    SCOPED_TRACE(words(model));
    simulated::plug_in(model);
    work();
    for (const std::string& fault : simulated::take_faults()) ADD_FAILURE() << fault;
  }
}

}  // namespace plumbline::test
