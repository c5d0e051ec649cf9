#include "commands/fusion_arguments.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <utility>

#include "cli/arguments.h"
#include "io/mesh.h"

namespace plumbline::app {
namespace {

constexpr const char* kAuto = "auto";
constexpr const char* kOff = "off";

/// A positive number and its unit: "4mm", "2 GB".
double parse_quantity(const std::string& text, const std::vector<std::pair<std::string_view, double>>& units,
                      const std::string& option, const std::string& advice) {
  std::size_t end = 0;
  double number = 0;
  try {
    number = std::stod(text, &end);
  } catch (const std::exception&) {
    end = 0;
  }
  while (end < text.size() && text[end] == ' ') ++end;
  for (const auto& [unit, factor] : units)
    if (end > 0 && text.substr(end) == unit && std::isfinite(number) && number > 0) return number * factor;
  throw UsageError("'" + text + "' is not understood", option, advice);
}

void check_mesh_name(const std::string& name) {
  if (std::filesystem::path(name).filename() != name)
    throw UsageError("'" + name + "' is no name of a file in the output folder", "--mesh",
                     "Give a name without a folder.");
  try {
    check_mesh_format(name);
  } catch (const Error&) {
    throw UsageError("the format of '" + name + "' is not known", "--mesh",
                     "Give a name that ends in .ply, .obj, .stl or .glb.");
  }
}

}  // namespace

void add_fusion_arguments(CLI::App& command, FusionArguments& arguments) {
  command
      .add_option(
          "--global", arguments.global,
          "Correct the path's drift where the camera came back: on (wherever it did), off, or auto (if it pays)")
      ->check(CLI::IsMember({"auto", "on", "off"}))
      ->capture_default_str()
      ->type_name("MODE");
  command
      .add_option("--detail", arguments.detail,
                  "Voxels of the final fusion: 4mm, 0.5cm …; auto: by the depth's noise; off: the volume's own mesh")
      ->capture_default_str()
      ->type_name("LENGTH");
  command.add_option("--memory", arguments.memory, "Of the final fusion: 2GB, 500MB …; auto: half of what is free")
      ->capture_default_str()
      ->type_name("SIZE");
  command
      .add_option("--mesh", arguments.files,
                  "Write the mesh under this name, too; its ending is the format: .ply, .obj, .stl or .glb")
      ->allow_extra_args(false)
      ->type_name("NAME");
  command
      .add_option("--max-triangles", arguments.max_triangles,
                  "Simplify the mesh of the final fusion to so many, 0: do not")
      ->capture_default_str()
      ->type_name("N");
}

void set_up_fusion(const FusionArguments& arguments, const std::string& preset, ReconstructionOptions* options) {
  if (arguments.global == "on" || (arguments.global == kAuto && preset == "plumbline"))
    options->global = arguments.global == kAuto ? GlobalCorrection::automatic : GlobalCorrection::on;
  options->mesh_files = arguments.files;
  for (const std::string& name : arguments.files) check_mesh_name(name);
  options->final_fusion = arguments.detail == kAuto ? preset == "plumbline" : arguments.detail != kOff;
  if (arguments.detail != kAuto && arguments.detail != kOff)
    options->fusion.detail = parse_quantity(arguments.detail, {{"mm", 1e-3}, {"cm", 1e-2}, {"m", 1}}, "--detail",
                                            "Give a length as 4mm, auto, or off.");
  if (arguments.memory != kAuto)
    options->fusion.memory = static_cast<std::size_t>(
        parse_quantity(arguments.memory, {{"GB", 1e9}, {"MB", 1e6}}, "--memory", "Give a size as 2GB, or auto."));
  options->fusion.max_triangles = arguments.max_triangles;
}

}  // namespace plumbline::app
