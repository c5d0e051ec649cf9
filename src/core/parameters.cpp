#include "core/parameters.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/error.h"

namespace plumbline {

Parameters preset(std::string_view name) {
  if (name == "kinectfusion") return {};
  throw Error("there is no such preset", fmt::format("preset '{}'", name),
              fmt::format("Choose one of: {}.", fmt::join(preset_names(), ", ")));
}

std::vector<std::string> preset_names() { return {"kinectfusion"}; }

}  // namespace plumbline
