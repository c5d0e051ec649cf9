// --global, --detail, --mesh and what else says how path and mesh of a run are finished.
#pragma once

#include <string>
#include <vector>

#include "run/reconstruction.h"

namespace CLI {
class App;
}

namespace plumbline::app {

struct FusionArguments {
  std::string detail = "auto", memory = "auto", global = "auto";
  std::vector<std::string> files;
  std::size_t max_triangles = 0;
};

void add_fusion_arguments(CLI::App& command, FusionArguments& arguments);

/// With "auto" there is a correction of the path and a final fusion for the preset `plumbline`; the others are what was
/// published.
/// Throws UsageError for what is no length, no size or no name of a mesh.
void set_up_fusion(const FusionArguments& arguments, const std::string& preset, ReconstructionOptions* options);

}  // namespace plumbline::app
