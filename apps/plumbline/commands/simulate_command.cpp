#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/arguments.h"
#include "cli/backend_arguments.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "core/threads.h"
#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "sim/scenes.h"
#include "sim/simulated_sequence.h"
#include "sim/trajectory.h"

namespace plumbline::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPoseForm = "\"TX TY TZ QX QY QZ QW\"";

struct SimulateArguments {
  std::string scene = "desk", trajectory = "orbit", output = "simulated", placement = "auto";
  std::string size = "640x480", intrinsics;
  std::string mounting = "0 0 0 1", lever = "0 0 0", disturbance, turn_axis = "any";
  int frames = 0, threads = 0;
  double rate = 30, speed = 1, turn = 0, clearance = 0.2;
  double tilt = 3, heading = 10, orientation_noise = 0, drift_ppm = 0;  // degrees; parts in a million
  bool exact = false, no_color = false, ideal = false, no_shadow = false, quiet = false;
  sim::PathOptions path;
  sim::DepthCameraOptions camera;
  sim::OrientationSensorOptions sensor;
  std::uint64_t seed = 1;
  std::optional<std::uint64_t> sensor_seed;
};

/// The path in the scene; notes what was done to it.
sim::Motion motion_of(const SimulateArguments& arguments, const sim::Scene& scene, SimulatedSequence* sequence) {
  sim::PathOptions path = arguments.path;
  path.seed = arguments.seed;
  PathPlacement placement;
  placement.clearance = arguments.clearance;
  if (arguments.placement == "none")
    placement.scene_from_path = SE3();
  else if (arguments.placement != "auto")
    placement.scene_from_path = parse_pose(arguments.placement, "--placement");
  const std::vector<std::string> kinds = sim::path_kinds();
  const bool made_up = std::find(kinds.begin(), kinds.end(), arguments.trajectory) != kinds.end();
  if (made_up || fs::exists(arguments.trajectory)) return choose_motion(path, scene, placement, sequence);
  return as_usage([&] { return choose_motion(path, scene, placement, sequence); });  // throws, naming the known ones
}

/// What is no file is a name.
sim::Scene scene_of(const std::string& name) {
  return fs::exists(name) ? load_scene(name) : as_usage([&] { return load_scene(name); });
}

Pinhole camera_of(const SimulateArguments& arguments) {
  const auto [width, height] = parse_size(arguments.size, "--size");
  if (arguments.intrinsics.empty()) return kinect(width, height);
  const std::vector<double> k = parse_numbers(arguments.intrinsics, 4, "--intrinsics", "fx,fy,cx,cy");
  return {static_cast<float>(k[0]),
          static_cast<float>(k[1]),
          static_cast<float>(k[2]),
          static_cast<float>(k[3]),
          width,
          height};
}

sim::OrientationSensorOptions sensor_of(const SimulateArguments& arguments, double duration) {
  sim::OrientationSensorOptions sensor = arguments.sensor;
  sensor.seed = arguments.sensor_seed.value_or(arguments.seed);
  sensor.clock_drift = 1e-6 * arguments.drift_ppm;
  sensor.orientation_noise = radians(arguments.orientation_noise);
  sensor.tilt_error = arguments.ideal ? 0 : radians(arguments.tilt);
  sensor.heading_error = arguments.ideal ? 0 : radians(arguments.heading);
  sensor.body_from_camera = parse_pose("0 0 0 " + arguments.mounting, "--imu-mounting").rotation();
  const std::vector<double> lever = parse_numbers(arguments.lever, 3, "--imu-lever", "\"X Y Z\"");
  sensor.lever_arm = {lever[0], lever[1], lever[2]};
  if (arguments.disturbance.empty()) return sensor;
  const std::vector<double> d =
      parse_numbers(arguments.disturbance, 5, "--magnetic-disturbance", "\"FROM TO EAST NORTH UP\"");
  sensor.disturbance_begin = d[0] * duration;
  sensor.disturbance_end = d[1] * duration;
  sensor.disturbance = {d[2], d[3], d[4]};
  return sensor;
}

int simulate(const SimulateArguments& arguments) {
  std::unique_ptr<tbb::global_control> limit;
  if (arguments.threads > 0)
    limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                  static_cast<std::size_t>(allowed_threads(arguments.threads)));
  SimulatedSequence sequence;
  const sim::Scene scene = scene_of(arguments.scene);
  sequence.scene = arguments.scene;
  sequence.trajectory = arguments.trajectory;
  sequence.speed = arguments.speed;
  const sim::Motion motion = motion_of(arguments, scene, &sequence);
  sequence.turn = radians(arguments.turn);
  sequence.turn_axis = arguments.turn_axis;
  sequence.rate = arguments.rate;
  sequence.seed = arguments.seed;
  sequence.camera = arguments.camera;
  sequence.camera.camera = camera_of(arguments);
  sequence.camera.noise = !arguments.exact;
  sequence.camera.color = !arguments.no_color;
  sequence.camera.model.shadow = !arguments.no_shadow;
  sequence.camera.seed = arguments.seed;
  const int whole = static_cast<int>(std::floor(motion.duration() * arguments.rate)) + 1;
  sequence.frames = arguments.frames > 0 ? std::min(arguments.frames, whole) : whole;
  sequence.duration = (sequence.frames - 1) / arguments.rate;
  sequence.sensor = sensor_of(arguments, sequence.duration);
  if (arguments.turn != 0) {
    const auto axis = arguments.turn_axis == "pan" ? sim::TurnAxis::pan : sim::TurnAxis::any;
    const auto pairs = std::make_shared<sim::TurnPairs>(motion, sequence.turn, axis, arguments.rate, arguments.seed);
    sequence.world_from_camera = [pairs](double t) { return pairs->at(t); };
  } else {
    sequence.world_from_camera = [motion](double t) { return motion.at(t); };
  }
  if (!arguments.quiet)
    say("rendering {} frames of the scene {} ({} triangles)", sequence.frames, arguments.scene,
        scene.mesh.triangles.size());
  const double seconds = write_simulated_sequence(arguments.output, scene.mesh, sequence);
  if (!arguments.quiet)
    say("{}: {} frames in {:.1f} s, {:.1f} a second", arguments.output, sequence.frames, seconds,
        sequence.frames / std::max(seconds, 1e-9));
  return 0;
}

void add_path_options(CLI::App& command, SimulateArguments& a) {
  command
      .add_option("--scene", a.scene,
                  "desk, room, kitchen, teddy, corridor, ring, floor, twins, or a PLY or OBJ file (metres, z up)")
      ->capture_default_str()
      ->type_name("NAME|FILE");
  command
      .add_option("--trajectory", a.trajectory,
                  "orbit, sweep, handheld, turntable, dance, walk, or a file in TUM's format")
      ->capture_default_str()
      ->type_name("KIND|FILE");
  command
      .add_option("--placement", a.placement,
                  "scene_from_trajectory: auto (where the path sees most of the scene), none, or a pose")
      ->capture_default_str()
      ->type_name("POSE");
  command.add_option("--clearance", a.clearance, "Metres that a placed path keeps to every surface")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str()
      ->type_name("M");
  command.add_option("--frames", a.frames, "Length of the sequence, 0 for the whole path")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str()
      ->type_name("N");
  command.add_option("--rate", a.rate, "Frames a second")->check(CLI::Range(0.01, 1e4))->capture_default_str();
  command.add_option("--speed", a.speed, "How much faster than it is the path is played")
      ->check(CLI::Range(0.01, 100.0))
      ->capture_default_str();
  command
      .add_option("--turn", a.turn, "Pairs of frames at one place, the camera turned by so many degrees between them")
      ->check(CLI::Range(0.0, 180.0))
      ->capture_default_str()
      ->type_name("DEG");
  command.add_option("--turn-axis", a.turn_axis, "Of --turn: pan (left or right), or any across the line of sight")
      ->check(CLI::IsMember({"pan", "any"}))
      ->capture_default_str()
      ->type_name("NAME");
  command.add_option("--duration", a.path.duration, "Of a made-up path, seconds")
      ->check(CLI::Range(0.1, 1e5))
      ->capture_default_str();
  command.add_option("--radius", a.path.radius, "Of a made-up path, metres from what it looks at; 0 = by the scene")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  command.add_option("--shake", a.path.shake, "Tremor of the hand on a made-up path, 1 = usual")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  command.add_option("--seed", a.seed, "Of everything random")->capture_default_str()->type_name("N");
}

void add_camera_options(CLI::App& command, SimulateArguments& a) {
  command.add_option("--size", a.size, "Of the images")->capture_default_str()->type_name("WxH");
  command.add_option("--intrinsics", a.intrinsics, "Pixels (default: a Kinect's field of view)")
      ->type_name("FX,FY,CX,CY");
  command.add_flag("--exact", a.exact, "Depth without the sensor's errors");
  command.add_option("--axial-noise", a.camera.model.axial, "Factor on the noise along the line of sight")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  command.add_option("--lateral-noise", a.camera.model.lateral, "Factor on the noise across it")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  command.add_option("--distortion", a.camera.model.distortion, "Of the sensor's own, pixels of disparity rms")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  command
      .add_option("--dark", a.camera.model.signal,
                  "No reading from surfaces with less than this reflectance · cos(incidence) / (depth/m)²")
      ->check(CLI::Range(0.0, 1e3))
      ->capture_default_str();
  command.add_option("--correlation", a.camera.model.correlation, "Pixels over which the noise is alike")
      ->check(CLI::Range(1.0, 100.0))
      ->capture_default_str();
  command.add_flag("--no-shadow", a.no_shadow, "Light the scene from the camera itself");
  command.add_option("--rolling-shutter", a.camera.readout, "Seconds from the first row to the last")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command.add_option("--exposure", a.camera.exposure, "Seconds over which a moving camera blurs the depth")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command.add_flag("--no-color,--no-colour", a.no_color, "Depth alone");
}

void add_sensor_options(CLI::App& command, SimulateArguments& a) {
  sim::OrientationSensorOptions& s = a.sensor;
  const auto number = [&](const char* name, double& value, const char* help, double low, double high) {
    command.add_option(name, value, help)->check(CLI::Range(low, high))->capture_default_str();
  };
  number("--imu-rate", s.rate, "Readings a second", 0.1, 1e5);
  number("--imu-latency", s.latency, "Seconds by which a reading's stamp is late", 0, 10);
  number("--imu-clock-offset", s.clock_offset, "Seconds by which the sensor's clock is ahead", -1e3, 1e3);
  number("--imu-clock-drift", a.drift_ppm, "Parts in a million by which it is fast", -9e4, 9e4);
  number("--imu-tilt", a.tilt, "Systematic error about the horizontal axes, degrees", 0, 180);
  number("--imu-heading", a.heading, "Systematic error of the heading, degrees", 0, 180);
  number("--imu-noise", a.orientation_noise, "White noise of the orientation, degrees rms", 0, 180);
  command.add_flag("--imu-ideal", a.ideal, "Orientation without systematic error");
  number("--gyro-noise", s.gyroscope_noise, "rad/s rms", 0, 100);
  number("--gyro-bias", s.gyroscope_bias, "At the start, rad/s rms", 0, 100);
  number("--gyro-bias-walk", s.gyroscope_bias_walk, "rad/s per square root of a second", 0, 100);
  number("--accelerometer-noise", s.accelerometer_noise, "m/s² rms", 0, 1000);
  number("--magnetometer-noise", s.magnetometer_noise, "µT rms", 0, 1e6);
  command
      .add_option("--magnetic-disturbance", a.disturbance,
                  "Field added over a part of the path: shares 0…1 of its time, then µT")
      ->type_name("\"FROM TO EAST NORTH UP\"");
  command.add_option("--imu-mounting", a.mounting, "body_from_camera")
      ->capture_default_str()
      ->type_name("\"QX QY QZ QW\"");
  command.add_option("--imu-lever", a.lever, "Position of the sensor in the camera's frame, metres")
      ->capture_default_str()
      ->type_name("\"X Y Z\"");
  command.add_option("--imu-seed", a.sensor_seed, "Of the sensor's errors (default: --seed)")->type_name("N");
}

}  // namespace

void add_simulate_command(CLI::App& app, Command& chosen) {
  const auto arguments = std::make_shared<SimulateArguments>();
  CLI::App* command =
      app.add_subcommand("simulate", "Make a sequence of a made-up scene, with exact truth and an orientation sensor");
  command->add_option("-o,--output", arguments->output, "Folder of the sequence, created if missing")
      ->capture_default_str()
      ->type_name("DIR");
  add_path_options(*command, *arguments);
  add_camera_options(*command, *arguments);
  add_sensor_options(*command, *arguments);
  add_threads_argument(*command, arguments->threads);
  command->add_flag("--quiet", arguments->quiet, "Print nothing but errors");
  command->footer(fmt::format(
      "Writes a TUM folder that `plumbline run` reads (depth/, rgb/, camera.json, groundtruth.txt), and "
      "beside\n"
      "it orientation.txt (t qx qy qz qw, earth_from_body, east-north-up), imu.csv, scene.ply and scene.toml.\n"
      "The world is the scene's own: z up. Placed poses are written {}.",
      kPoseForm));
  command->callback([arguments, &chosen] { chosen = [arguments] { return simulate(*arguments); }; });
}

}  // namespace plumbline::app
