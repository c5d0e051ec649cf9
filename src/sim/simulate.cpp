#include "plumbline/simulate.h"

#include <algorithm>
#include <cmath>

#include "plumbline/error.h"
#include "sim/scenes.h"
#include "sim/simulated_sequence.h"

namespace plumbline {
namespace {

void check(const SimulateOptions& options) {
  const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
  if (!positive(options.rate) || !positive(options.speed) || !positive(options.duration))
    throw Error("rate, speed and duration must be greater than 0", "simulate", "Give positive numbers.");
  if (options.frames < 0) throw Error("a sequence cannot have fewer than no frames", "simulate", "Give 0 for all.");
  if (!options.camera.is_valid())
    throw Error("the camera has no pixels or no focal length", "simulate", "Give fx, fy, width and height above 0.");
}

}  // namespace

Simulation simulate(const std::string& folder, const SimulateOptions& options) {
  check(options);
  SimulatedSequence sequence;
  sequence.scene = options.scene;
  sequence.trajectory = options.path;
  sequence.speed = options.speed;
  sequence.rate = options.rate;
  sequence.seed = options.seed;
  const sim::Scene scene = load_scene(options.scene);
  sim::PathOptions path;
  path.duration = options.duration;
  path.seed = options.seed;
  const sim::Motion motion = choose_motion(path, scene, {}, &sequence);
  sequence.world_from_camera = [motion](double t) { return motion.at(t); };
  const int whole = static_cast<int>(std::floor(motion.duration() * options.rate)) + 1;
  sequence.frames = options.frames > 0 ? std::min(options.frames, whole) : whole;
  sequence.duration = (sequence.frames - 1) / options.rate;
  sequence.camera.camera = options.camera;
  sequence.camera.noise = options.noise;
  sequence.camera.color = options.color;
  sequence.camera.seed = options.seed;
  sequence.sensor.seed = options.seed;
  sequence.sensor.tilt_error = options.tilt_error;
  sequence.sensor.heading_error = options.heading_error;
  write_simulated_sequence(folder, scene.mesh, sequence);
  return {true_trajectory(sequence), scene.mesh};
}

std::vector<std::string> scene_names() { return sim::scene_names(); }
std::vector<std::string> path_names() { return sim::path_kinds(); }

}  // namespace plumbline
