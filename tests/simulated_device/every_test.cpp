// Every test of this executable has a fresh device, and fails of what the device finds wrong. Each repetition
// (--gtest_repeat) has another seed and another number of processors.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "simulated_device/device.h"

namespace plumbline {
namespace {

class PlugIn : public testing::EmptyTestEventListener {
  void OnTestIterationStart(const testing::UnitTest&, int iteration) override {
    static constexpr int kProcessors[] = {7, 1, 2, 132};
    static const int capabilities[] = {90, 75, 80, 100};
    const char* first = std::getenv("PLUMBLINE_DEVICE_SEED");
    model_.seed = (first != nullptr ? std::stoull(first) : 1) + static_cast<unsigned>(iteration);
    model_.processors = kProcessors[model_.seed % 4];
    model_.capability = capabilities[model_.seed % 4];
  }
  void OnTestStart(const testing::TestInfo&) override { simulated::plug_in(model_); }
  void OnTestEnd(const testing::TestInfo&) override {
    for (const std::string& fault : simulated::take_faults())
      ADD_FAILURE() << fault << "\n  (seed " << model_.seed << ", " << model_.processors << " processors)";
  }
  simulated::Model model_;
};

const bool kListens = [] {
  testing::UnitTest::GetInstance()->listeners().Append(new PlugIn());
  return true;
}();

}  // namespace
}  // namespace plumbline
