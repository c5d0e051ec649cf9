// libFuzzer's end of the targets: plumbline_fuzz --target=NAME [libFuzzer's options] CORPUS…
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "fuzz/targets.h"

namespace {
std::string target;  // libFuzzer hands over nothing but bytes
}

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  for (int i = 1; i < *argc; ++i)
    if (const std::string word = (*argv)[i]; word.starts_with("--target=")) target = word.substr(9);
  if (plumbline::fuzz::run_target(target, {})) return 0;
  std::fputs("usage: plumbline_fuzz --target=NAME CORPUS..., NAME one of", stderr);
  for (const std::string& name : plumbline::fuzz::target_names()) std::fprintf(stderr, " %s", name.c_str());
  std::fputs("\n", stderr);
  std::exit(2);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  plumbline::fuzz::run_target(target, {reinterpret_cast<const char*>(data), size});
  return 0;
}
