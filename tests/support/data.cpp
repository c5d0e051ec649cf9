#include "support/data.h"

#include <cstdlib>

namespace plumbline::test {

std::filesystem::path data_root() {
  if (const char* root = std::getenv("PLUMBLINE_DATA")) return root;
  return std::filesystem::path(PLUMBLINE_SOURCE_DIR) / ".." / "shared" / "data";
}

}  // namespace plumbline::test
