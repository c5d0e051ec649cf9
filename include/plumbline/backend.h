// What computes: the CPU with one of its instruction sets, or a GPU.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "plumbline/export.h"

namespace plumbline {

/// Runs the kernels of one device. Opaque to users of the library: made by `make_backend`, given to a `Pipeline`.
class Backend;

struct BackendInfo {
  std::string name;
  bool available = false;
  std::string description;  ///< what it is, or why it is not available
};

/// "auto" (what is known to work: the CPU), "cpu", "cpu:avx2+fma" (with that instruction set), or "cuda". `threads` of
/// 0 takes all of the machine's; other backends ignore it. Throws Error for a name that is unknown or not available
/// here.
PLUMBLINE_EXPORT std::shared_ptr<Backend> make_backend(const std::string& name = "auto", int threads = 0);
PLUMBLINE_EXPORT std::vector<BackendInfo> list_backends();

}  // namespace plumbline
