#include <tbb/parallel_for.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>

#include "app/commands.h"
#include "app/console.h"
#include "app/demo_report.h"
#include "app/reconstruction.h"
#include "core/error.h"
#include "io/atomic_file.h"
#include "io/png.h"
#include "io/text_file.h"
#include "io/trajectory.h"
#include "sim/analytic_scene.h"
#include "sim/mesh_renderer.h"

namespace plumbline::app {
namespace {

namespace fs = std::filesystem;

constexpr Pinhole kCamera{262.5f, 262.5f, 159.5f, 119.5f, 320, 240};  // a Kinect's field of view at half its size
constexpr Pinhole kPictureCamera{1100.0f, 1100.0f, 639.5f, 479.5f, 1280, 960};
constexpr double kDepthScale = 5000;

struct DemoArguments {
  std::string output = "demo", command_line;
  int frames = 180;
  int threads = 0;
};

void write_text(const fs::path& path, const std::string& text) {
  AtomicFile file(path.string());
  file.write(text);
  file.commit();
}

std::string image_name(const char* folder, Nanoseconds time) {
  return fmt::format("{}/{}.png", folder, format_seconds(time, 9));
}

std::string image_list(const char* folder, const Trajectory& poses) {
  std::string list = "# timestamp filename\n";
  for (const StampedPose& pose : poses)
    list += fmt::format("{} {}\n", format_seconds(pose.time, 9), image_name(folder, pose.time));
  return list;
}

/// Renders the scene along the poses into a TUM RGB-D folder.
void write_sequence(const fs::path& folder, const sim::AnalyticScene& scene, const Trajectory& poses) {
  for (const char* name : {"depth", "rgb"}) ensure_directory((folder / name).string());
  tbb::parallel_for(std::size_t{0}, poses.size(), [&](std::size_t i) {
    const Frame frame = sim::render(scene, kCamera, poses[i].world_from_camera, poses[i].time, kDepthScale);
    write_depth_png((folder / image_name("depth", poses[i].time)).string(), frame.depth);
    write_color_png((folder / image_name("rgb", poses[i].time)).string(), frame.color);
  });
  write_text(folder / "camera-intrinsics.txt",
             fmt::format("{} 0 {}\n0 {} {}\n0 0 1\n", kCamera.fx, kCamera.cx, kCamera.fy, kCamera.cy));
  write_tum_trajectory((folder / "groundtruth.txt").string(), poses);
  write_text(folder / "rgb.txt", image_list("rgb", poses));
  write_text(folder / "depth.txt", image_list("depth", poses));  // last: with it the folder is a sequence
}

ReconstructionOptions demo_options(const DemoArguments& arguments, const SE3& initial_pose) {
  ReconstructionOptions options;
  options.sequence = (fs::path(arguments.output) / "sequence").string();
  options.output = (fs::path(arguments.output) / "run").string();
  options.parameters = preset("kinectfusion");
  options.parameters.volume.resolution = 384;
  options.parameters.volume.side = 4.0;
  options.parameters.volume.offset = 0.0;
  options.threads = arguments.threads;
  options.initial_pose = initial_pose;  // so that the mesh lies in the scene's own frame
  options.command_line = arguments.command_line;
  return options;
}

eval::Statistics surface_error(const Mesh& mesh, const sim::AnalyticScene& scene) {
  std::vector<double> distances(mesh.positions.size());
  tbb::parallel_for(std::size_t{0}, distances.size(), [&](std::size_t i) {
    const Mesh::Float3& p = mesh.positions[i];
    distances[i] = scene.distance({p.x, p.y, p.z});
  });
  return eval::statistics(distances);
}

void write_picture(const std::string& path, const Reconstruction& run) {
  const sim::MeshRenderer renderer(run.mesh);
  sim::RenderOptions options;
  options.path = run.trajectory;
  write_color_png(path, renderer.render(kPictureCamera, renderer.default_view(kPictureCamera, options.up), options));
}

int demo(const DemoArguments& arguments) {
  const fs::path folder(arguments.output);
  const sim::AnalyticScene scene = sim::desk_corner();
  sim::OrbitOptions orbit;
  orbit.frames = arguments.frames;
  const Trajectory poses = sim::orbit(orbit);
  say("rendering {} frames of a desk in the corner of a room", poses.size());
  write_sequence(folder / "sequence", scene, poses);

  const Reconstruction run = reconstruct(demo_options(arguments, poses.front().world_from_camera));
  if (run.signal != 0) return 128 + run.signal;
  const std::string picture = (folder / "mesh.png").string(), report = (folder / "report.html").string();
  write_picture(picture, run);
  const DemoResult result{run, surface_error(run.mesh, scene), read_file(picture)};
  write_text(report, report_html(result));
  say("\n{}\n\nreport   {}\npicture  {}\nmesh     {}", verdict(result), report, picture,
      (folder / "run" / "mesh.ply").string());
  return 0;
}

}  // namespace

void add_demo_command(CLI::App& app, Command& chosen, const std::string& command_line) {
  const auto arguments = std::make_shared<DemoArguments>();
  arguments->command_line = command_line;
  CLI::App* command = app.add_subcommand("demo", "Scan a made-up desk and show how well that went");
  command->add_option("-o,--output", arguments->output, "Folder for all of it")
      ->capture_default_str()
      ->type_name("DIR");
  command->add_option("--frames", arguments->frames, "Length of the sequence")
      ->check(CLI::Range(3, 10000))
      ->capture_default_str()
      ->type_name("N");
  command->add_option("--threads", arguments->threads, "CPU threads, 0 for all")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str()
      ->type_name("N");
  command->callback([arguments, &chosen] { chosen = [arguments] { return demo(*arguments); }; });
}

}  // namespace plumbline::app
