// The simulated device as tests see it: what it is like, and what it found wrong. It stands behind the CUDA runtime
// that tests/simulated_device/runtime.h declares, so that `make_cuda_backend` gives a backend on it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace plumbline::simulated {

/// What NVIDIA's table "Technical specifications per compute capability" says of a device, and the kernel's own limits.
struct Limits {
  int capability;                   ///< 75 is sm_75
  int threads_of_processor;         ///< that one can hold at a time
  int blocks_of_processor;          ///< as well
  std::size_t shared_of_processor;  ///< bytes
  std::size_t shared_reserved;      ///< bytes of each block that the system takes
};
const std::vector<Limits>& known_limits();

struct Model {
  bool available = true;
  bool cooperative = true;
  int processors = 4;
  int capability = 90;     ///< one of known_limits()
  std::uint64_t seed = 1;  ///< of the order of blocks, of threads between barriers, and of streams
};

/// The device that is there from now on, with no error and nothing reported. No backend may be alive.
void plug_in(const Model& model);

/// What was found wrong since the previous call, one sentence each; the same thing is said once.
std::vector<std::string> take_faults();

/// A kernel as it was launched.
struct Launch {
  std::string kernel;
  std::size_t blocks = 0;
  int threads = 0;                 ///< of a block
  std::size_t dynamic_shared = 0;  ///< bytes
  std::size_t touched_shared = 0;  ///< bytes that it declares itself and that some block touched
  bool cooperative = false;
};
/// Since the previous call, one for each kernel, with the largest of each figure.
std::vector<Launch> take_launches();

/// Bytes of the host's side that no kernel may touch: for tests of the checks themselves.
bool is_device_address(const void* address);

}  // namespace plumbline::simulated
