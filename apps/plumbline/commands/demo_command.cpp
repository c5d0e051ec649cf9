#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "cli/console.h"
#include "commands/error_color.h"
#include "io/images/png.h"
#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/files.h"
#include "plumbline/mesh.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "plumbline/surface_error.h"
#include "plumbline/trajectory.h"
#include "report/report.h"
#include "run/reconstruction.h"
#include "sensor/error_model.h"
#include "sim/mesh_renderer.h"
#include "sim/scenes.h"
#include "sim/simulated_sequence.h"
#include "sim/trajectory.h"

namespace plumbline::app {
namespace {

namespace fs = std::filesystem;

constexpr Pinhole kCamera{262.5f, 262.5f, 159.5f, 119.5f, 320, 240};  // a Kinect's field of view at half its size
constexpr Pinhole kPictureCamera{1100.0f, 1100.0f, 639.5f, 479.5f, 1280, 960};
constexpr double kErrorRange = 0.02;                             // metres that are red
constexpr double kGoodTrajectory = 0.010, kGoodSurface = 0.010;  // metres
constexpr double kFast = 4;
constexpr int kFastFrames = 148;  // before they are played faster; then the hand comes too near to see anything

struct DemoArguments {
  std::string output = "demo", command_line;
  int frames = 180;
  int threads = 0;
};

/// The desk along a path, `speed` times as fast as a calm hand, with an early depth camera's errors.
SimulatedSequence demo_sequence(const sim::Scene& scene, const char* kind, int frames, double speed) {
  constexpr double kArc = 8;  // seconds; a longer sequence has a longer one
  SimulatedSequence sequence;
  sim::PathOptions path;
  path.duration = std::max(kArc, (frames - 1) / sequence.rate);
  const sim::Motion motion = sim::make_path(kind, scene, path).faster(speed);
  sequence.scene = scene.name;
  sequence.trajectory = kind;
  sequence.speed = speed;
  sequence.frames = std::max(3, static_cast<int>(frames / speed));
  sequence.duration = (sequence.frames - 1) / sequence.rate;
  sequence.world_from_camera = [motion](double t) { return motion.at(t); };
  sequence.camera.camera = kCamera;
  sequence.camera.model.distortion = 0;  // a calibrated one
  sequence.placement = sim::judge(motion, scene, SE3());
  return sequence;
}

ReconstructionOptions demo_options(const DemoArguments& arguments, const SE3& initial_pose, const char* sequence,
                                   const char* run) {
  ReconstructionOptions options;
  options.sequence = (fs::path(arguments.output) / sequence).string();
  options.output = (fs::path(arguments.output) / run).string();
  options.parameters = preset("plumbline");
  options.parameters.volume.resolution = 384;
  options.parameters.volume.side = 4.0;
  options.parameters.volume.offset = 0.0;
  options.parameters.volume.truncation = 0.04;
  options.threads = arguments.threads;
  options.final_fusion = true;
  options.initial_pose = initial_pose;  // so that the mesh lies in the scene's own frame
  options.report = false;               // the demo has its own
  options.command_line = arguments.command_line;
  return options;
}

/// The mesh from where most of what was scanned from near by is seen, with the camera's path.
void write_picture(const std::string& path, const Mesh& mesh, const Trajectory& trajectory) {
  const sim::MeshRenderer renderer(mesh);
  sim::RenderOptions options;
  options.path = trajectory;
  write_color_png(
      path, renderer.render(kPictureCamera, renderer.default_view(kPictureCamera, options.up, trajectory), options));
}

/// Green for none, over yellow to red for 2 cm and more.
Mesh painted_by_error(Mesh mesh, const std::vector<double>& errors) {
  mesh.colors.clear();
  for (const double error : errors) mesh.colors.push_back(error_color(error, kErrorRange));
  return mesh;
}

/// What became of the camera in a run, in half a sentence.
std::string outcome(const ReconstructionOptions& options) {
  try {
    const Reconstruction run = reconstruct(options);
    return fmt::format("{} of {} frames were lost, and the camera's path is {} from the truth", run.lost(),
                       run.frames.size(),
                       run.ate ? fmt::format("{:.1f} mm (rmse)", 1e3 * run.ate->translation.rmse)
                               : std::string("an unknown distance"));
  } catch (const Error&) {
    return "the camera was lost at once";
  }
}

/// A hand that moves several times as fast: what that does to the classical method, and what ours makes of it with an
/// orientation sensor.
std::string fast_motion(const DemoArguments& arguments, const sim::Scene& scene) {
  SimulatedSequence sequence = demo_sequence(scene, "handheld", kFastFrames, kFast);
  const Eigen::Vector3d chip = error_model("bno055").amplitude;
  sequence.sensor.tilt_error = chip.x();
  sequence.sensor.heading_error = chip.z();
  const fs::path folder(arguments.output);
  write_simulated_sequence((folder / "sequence_fast").string(), scene.mesh, sequence);
  ReconstructionOptions options = demo_options(arguments, sequence.world_from_camera(0), "sequence_fast", "run_fast");
  options.quiet = true;
  options.mesh = false;
  const Parameters ours = options.parameters;
  options.parameters = preset("kinectfusion");
  options.parameters.volume = ours.volume;
  const std::string without = outcome(options);
  options.parameters = ours;
  options.orientation.emplace(read_orientations((folder / "sequence_fast" / "orientation.txt").string(), {}),
                              OrientationStreamOptions());
  options.output = (folder / "run_fast_with_sensor").string();
  return fmt::format(
      "A hand that moves {:g} times as fast. KinectFusion: {}. Plumbline with the orientation of a cheap sensor, off "
      "by up to {:g}° of tilt and {:g}° of heading: {}.",
      kFast, without, degrees(chip.x()), degrees(chip.z()), outcome(options));
}

/// Whether the demo shows what it should.
Verdict demo_verdict(const Reconstruction& run, const eval::Statistics& surface) {
  const bool tracked = run.lost() == 0 && run.ate;
  if (tracked && run.ate->translation.rmse <= kGoodTrajectory && surface.mean <= kGoodSurface)
    return {Verdict::Level::good,
            fmt::format("It works: all {} frames were tracked, the camera's path is within {:.1f} mm (rmse) of the "
                        "truth, and the mesh lies {:.1f} mm (mean) from the true surfaces.",
                        run.frames.size(), 1e3 * run.ate->translation.rmse, 1e3 * surface.mean)};
  return {Verdict::Level::poor,
          fmt::format("This is not as good as it should be: {} of {} frames were lost, the camera's path is {} from "
                      "the truth, and the mesh lies {:.1f} mm (mean) from the true surfaces.",
                      run.lost(), run.frames.size(),
                      run.ate ? fmt::format("{:.1f} mm (rmse)", 1e3 * run.ate->translation.rmse)
                              : std::string("an unknown distance"),
                      1e3 * surface.mean)};
}

Report demo_report(const Reconstruction& run, std::vector<double> errors, const std::string& fast) {
  const eval::Statistics surface = eval::statistics(errors);
  Report report = report_of(run);
  report.title = "Plumbline demo";
  report.verdict = demo_verdict(run, surface);
  report.remarks = {fast};
  report.facts.insert(report.facts.begin() + 2, {"Surface error", fmt::format("{:.1f} mm", 1e3 * surface.mean),
                                                 fmt::format("mean; median {:.1f}\u00a0mm, rmse {:.1f}\u00a0mm",
                                                             1e3 * surface.median, 1e3 * surface.rmse)});
  report.surface_errors = std::move(errors);
  report.error_range = kErrorRange;
  return report;
}

int demo(const DemoArguments& arguments) {
  const fs::path folder(arguments.output);
  const sim::Scene scene = sim::make_scene("desk");
  const SimulatedSequence sequence = demo_sequence(scene, "orbit", arguments.frames, 1);
  say("simulating {} frames of a desk in an office", sequence.frames);
  write_simulated_sequence((folder / "sequence").string(), scene.mesh, sequence);

  const Reconstruction run = reconstruct(demo_options(arguments, sequence.world_from_camera(0), "sequence", "run"));
  if (run.signal != 0) return 128 + run.signal;
  const std::vector<double> errors = eval::distances_to_mesh(run.mesh.positions, scene.mesh);
  const std::string picture = (folder / "mesh.png").string(), error_picture = (folder / "error.png").string(),
                    page = (folder / "report.html").string();
  write_picture(picture, run.mesh, run.trajectory);
  write_picture(error_picture, painted_by_error(run.mesh, errors), run.trajectory);
  const Report report = demo_report(run, errors, fast_motion(arguments, scene));
  if (can_report()) write_report(page, report);
  say("\n{}\n{}\n", report.verdict.text, report.remarks.front());
  say("report   {}", can_report() ? page : "none: this program was built without it (PLUMBLINE_REPORT)");
  say("picture  {}\nerrors   {}\nmesh     {}", picture, error_picture, (folder / "run" / "mesh.ply").string());
  return 0;
}

}  // namespace

void add_demo_command(CLI::App& app, Command& chosen, const std::string& command_line) {
  const auto arguments = std::make_shared<DemoArguments>();
  arguments->command_line = command_line;
  CLI::App* command = app.add_subcommand("demo", "Scan a simulated desk and show how well that went");
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
