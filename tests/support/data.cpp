#include "support/data.h"

#include <cstdlib>

#include "support/source.h"

namespace plumbline::test {

std::filesystem::path data_root() {
  if (const char* root = std::getenv("PLUMBLINE_DATA")) return root;
  return std::filesystem::path(PLUMBLINE_SOURCE_DIR) / ".." / "shared" / "data";
}

std::filesystem::path source_root() { return PLUMBLINE_SOURCE_DIR; }

}  // namespace plumbline::test
