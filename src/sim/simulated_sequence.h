// The folder of a simulated sequence: images, truth, sensor readings, and how it was made.
#pragma once

#include <optional>
#include <string>

#include "plumbline/mesh.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"
#include "sim/depth_camera.h"
#include "sim/orientation_sensor.h"
#include "sim/scenes.h"
#include "sim/trajectory.h"

namespace plumbline {

/// What is simulated.
struct SimulatedSequence {
  std::string scene, trajectory;  ///< as given
  std::string turn_axis = "any";  ///< of `turn`: any, pan
  double speed = 1, turn = 0;     ///< turn in radians
  double rate = 30;               ///< frames a second
  double duration = 0;            ///< seconds from the first frame to the last
  int frames = 0;
  std::uint64_t seed = 1;
  Nanoseconds start = kNanosecondsPerSecond;  ///< of the first frame
  sim::PoseAt world_from_camera;              ///< time 0 is the first frame
  sim::DepthCameraOptions camera;
  sim::OrientationSensorOptions sensor;
  sim::Placement placement;
  std::optional<sim::Smoothing> smoothing;  ///< of a recorded path
};

/// One of `sim::scene_names()`, or a PLY or OBJ file. Throws Error for other names.
sim::Scene load_scene(const std::string& name);

/// How a path comes into a scene.
struct PathPlacement {
  std::optional<SE3> scene_from_path;  ///< empty: where the path sees most of the scene
  double clearance = 0.2;              ///< metres that a placed path keeps to every surface
};

/// `sequence->trajectory` (one of `sim::path_kinds()`, or a file in TUM's format) in the scene, played at the
/// sequence's speed. Notes in the sequence where it was placed and what a recorded path lost. Throws Error for other
/// names.
sim::Motion choose_motion(const sim::PathOptions& path, const sim::Scene& scene, const PathPlacement& placement,
                          SimulatedSequence* sequence);

/// A Kinect's field of view.
Pinhole kinect(int width, int height);

/// Stamp of a frame: whole microseconds, as TUM's files have them.
Nanoseconds frame_time(const SimulatedSequence& sequence, int index);

/// Poses of the frames.
Trajectory true_trajectory(const SimulatedSequence& sequence);

/// Renders the frames in parallel and writes everything into the folder; returns the seconds that the images took. The
/// bytes do not depend on the number of threads. Throws Error for options out of range and files that cannot be
/// written.
double write_simulated_sequence(const std::string& folder, const Mesh& mesh, const SimulatedSequence& sequence);

}  // namespace plumbline
