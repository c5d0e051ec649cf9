#include <gtest/gtest.h>

#include "backend/cuda/cuda.h"

namespace plumbline {
namespace {
TEST(SimulatedDevice, IsTheOneThatIsThere) { EXPECT_EQ(make_cuda_backend()->description(), "cuda (simulated device)"); }
}  // namespace
}  // namespace plumbline
