#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>

#include "cli/arguments.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "io/images/png.h"
#include "io/mesh.h"
#include "io/trajectory.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "sim/mesh_renderer.h"

namespace plumbline::app {
namespace {

struct RenderArguments {
  std::string mesh, output = "mesh.png", pose, size = "1280x960", trajectory, up = "0,-1,0";
  double field_of_view = 55;
  bool no_color = false;
};

Pinhole camera_of(const RenderArguments& arguments) {
  const auto [width, height] = parse_size(arguments.size, "--size");
  const double half_angle = arguments.field_of_view * std::numbers::pi / 360;
  const auto focal = static_cast<float>(0.5 * width / std::tan(half_angle));
  return {focal, focal, 0.5f * static_cast<float>(width - 1), 0.5f * static_cast<float>(height - 1), width, height};
}

int render(const RenderArguments& arguments) {
  const Pinhole camera = camera_of(arguments);
  const std::vector<double> up = parse_numbers(arguments.up, 3, "--up", "x,y,z");
  sim::RenderOptions options;
  options.up = {up[0], up[1], up[2]};
  if (options.up.norm() == 0) throw UsageError("the direction is zero", "--up", "Write x,y,z, for example 0,0,1.");
  options.up.normalize();
  options.vertex_colors = !arguments.no_color;
  if (!arguments.trajectory.empty()) options.path = read_trajectory(arguments.trajectory);
  const sim::MeshRenderer renderer(read_mesh(arguments.mesh));
  const SE3 world_from_camera = arguments.pose.empty() ? renderer.default_view(camera, options.up, options.path)
                                                       : parse_pose(arguments.pose, "--pose");
  write_color_png(arguments.output, renderer.render(camera, world_from_camera, options), Durable::yes);
  say("{}", arguments.output);
  return 0;
}

}  // namespace

void add_render_command(CLI::App& app, Command& chosen) {
  const auto arguments = std::make_shared<RenderArguments>();
  CLI::App* command = app.add_subcommand("render", "Make a picture of a mesh");
  command->add_option("mesh", arguments->mesh, "PLY or OBJ file")->required()->type_name("MESH");
  command->add_option("-o,--output", arguments->output, "PNG file")->capture_default_str()->type_name("FILE");
  command
      ->add_option("--pose", arguments->pose,
                   "Camera in the world (default: a view of the whole mesh; with --trajectory, of what was scanned "
                   "from near by)")
      ->type_name("\"TX TY TZ QX QY QZ QW\"");
  command->add_option("--size", arguments->size, "Size of the picture")->capture_default_str()->type_name("WxH");
  command->add_option("--fov", arguments->field_of_view, "Horizontal field of view in degrees")
      ->check(CLI::Range(1.0, 170.0))
      ->capture_default_str()
      ->type_name("DEG");
  command->add_option("--trajectory", arguments->trajectory, "Draw this trajectory too")->type_name("FILE");
  command->add_option("--up", arguments->up, "Direction that is up; a run's world has the first camera's axes, y down")
      ->capture_default_str()
      ->type_name("X,Y,Z");
  command->add_flag("--no-color,--no-colour", arguments->no_color, "Show the shape alone");
  command->callback([arguments, &chosen] { chosen = [arguments] { return render(*arguments); }; });
}

}  // namespace plumbline::app
