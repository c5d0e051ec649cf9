// Every backend and lane type that this machine has: each compiled instruction set of the CPU, "scalar", the plain
// `float` lane that a GPU thread runs too and that no vector code stands between, and "cuda" where there is a device.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <memory>
#include <string>
#include <vector>

#include "backend/cpu/cpu.h"
#include "backend/cuda/cuda.h"

namespace plumbline::cpu {
/// lanes.cpp compiled for PLUMBLINE_LANE=float; see CMakeLists.txt.
Backend* make_lanes_scalar(int threads, const char* instruction_set);
}  // namespace plumbline::cpu

namespace plumbline::test {

inline std::vector<std::string> lane_types() {
  std::vector<std::string> result = cpu_instruction_sets();
  result.emplace_back("scalar");
  if (cuda_info().available) result.emplace_back("cuda");
  return result;
}

inline std::shared_ptr<Backend> make_lanes(const std::string& lane_type, int threads = 1) {
  if (lane_type == "scalar") return std::shared_ptr<Backend>(cpu::make_lanes_scalar(threads, "scalar"));
  if (lane_type == "cuda") return make_cuda_backend(CudaMemory::managed);  // tests look into its memory
  return make_cpu_backend(threads, lane_type);
}

/// A fixture whose tests run once a lane type.
class LaneTest : public testing::TestWithParam<std::string> {
 protected:
  LaneTest() : backend_(make_lanes(GetParam())) {}
  const Backend& backend() const { return *backend_; }

 private:
  std::shared_ptr<Backend> backend_;
};

inline std::string lane_test_name(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return name;
}

#define PLUMBLINE_ON_EVERY_LANE_TYPE(fixture)                                                \
  INSTANTIATE_TEST_SUITE_P(Lanes, fixture, testing::ValuesIn(plumbline::test::lane_types()), \
                           plumbline::test::lane_test_name)

}  // namespace plumbline::test
