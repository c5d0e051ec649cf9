#include "sim/simulated_sequence.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>

#include "io/atomic_file.h"
#include "io/images/png.h"
#include "io/imu_file.h"
#include "io/mesh.h"
#include "io/recorded_camera.h"
#include "io/trajectory.h"
#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/files.h"
#include "plumbline/mesh.h"
#include "plumbline/orientation.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

std::string image_name(const char* folder, Nanoseconds time) {
  return fmt::format("{}/{}.png", folder, format_seconds(time));
}

std::string image_list(const char* folder, const Trajectory& poses) {
  std::string list = "# timestamp filename\n";
  for (const StampedPose& pose : poses)
    list += fmt::format("{} {}\n", format_seconds(pose.time), image_name(folder, pose.time));
  return list;
}

std::vector<OrientationSample> orientations(const std::vector<sim::InertialSample>& samples) {
  std::vector<OrientationSample> list;
  for (const sim::InertialSample& s : samples) list.push_back({s.time, s.earth_from_body});
  return list;
}

ImuRecording imu_recording(const std::vector<sim::InertialSample>& samples) {
  ImuRecording recording{.samples = {}, .has_gyroscope = true, .has_magnetometer = true};
  recording.samples.reserve(samples.size());
  for (const sim::InertialSample& s : samples)
    recording.samples.push_back({s.time, s.angular_rate, s.specific_force, s.magnetic_field});
  return recording;
}

std::string toml_string(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) >= 0x20 && c != 0x7f) out += c;
  }
  return out + "\"";
}

std::string numbers(const Eigen::Vector3d& v) { return fmt::format("[{:.9g}, {:.9g}, {:.9g}]", v.x(), v.y(), v.z()); }

/// [tx, ty, tz, qx, qy, qz, qw].
std::string pose_numbers(const SE3& pose) {
  const Eigen::Quaterniond q = pose.quaternion();
  const Eigen::Vector3d& t = pose.translation();
  return fmt::format("[{:.9f}, {:.9f}, {:.9f}, {:.9f}, {:.9f}, {:.9f}, {:.9f}]", t.x(), t.y(), t.z(), q.x(), q.y(),
                     q.z(), q.w());
}

std::string smoothing_toml(const SimulatedSequence& s) {
  if (!s.smoothing) return "";
  return fmt::format(
      "# the recorded poses were smoothed: local quadratic regression over 60 ms either side, cubic B-spline\n"
      "smoothing_rms = {:.6f}  # m\nsmoothing_rms_deg = {:.4f}\nlongest_gap = {:.3f}  # s without a recorded pose\n",
      s.smoothing->translation_rms, degrees(s.smoothing->rotation_rms), s.smoothing->longest_gap);
}

std::string motion_toml(const SimulatedSequence& s) {
  const std::string text = fmt::format(
      "[motion]\ntrajectory = {}\nspeed = {:.9g}\nturn_deg = {:.9g}\nturn_axis = {}\nframes = {}\nrate = {:.9g}  # Hz\n"
      "# scene_from_trajectory, tx ty tz qx qy qz qw; for a recorded path: turned about the vertical and moved so that "
      "it\n"
      "# sees most of the scene, keeps clear of every surface and passes through none\nplacement = {}\n"
      "clearance = {:.3f}  # m from the camera to the nearest surface, at most 1; negative: passes through one\n"
      "rays_in_range = {:.3f}  # share that meets a surface between 0.5 and 4 m\n"
      "rays_on_focus = {:.3f}  # share that ends within the scene's focus\n",
      toml_string(s.trajectory), s.speed, degrees(s.turn), toml_string(s.turn_axis), s.frames, s.rate,
      pose_numbers(s.placement.scene_from_recorded), s.placement.clearance, s.placement.share_in_range,
      s.placement.share_on_focus);
  return text + smoothing_toml(s) + "\n";
}

std::string camera_toml(const sim::DepthCameraOptions& c) {
  const sim::DepthNoise& n = c.model;
  return fmt::format(
      "[camera]\nwidth = {}\nheight = {}\nfx = {:.9g}\nfy = {:.9g}\ncx = {:.9g}\ncy = {:.9g}\n"
      "depth_scale = {:.9g}  # readings per metre\nrolling_shutter = {:.9g}  # s\nexposure = {:.9g}  # s\n"
      "exposure_samples = {}\n\n[depth_noise]\nenabled = {}\naxial = {:.9g}  # factor on Nguyen et al. 2012\n"
      "lateral = {:.9g}  # factor on the same\nbaseline = {:.9g}  # m\nfocal_length = {:.9g}  # px\n"
      "disparity_step = {:.9g}  # px\ncorrelation = {:.9g}  # px\ndistortion = {:.9g}  # px rms\nmin_range = {:.9g}  # "
      "m\nmax_range = {:.9g}  # m\n"
      "grazing_start_deg = {:.6g}\ngrazing_end_deg = {:.6g}\nedge_holes = {:.9g}\nsignal = {:.9g}\nshadow = {}\n\n",
      c.camera.width, c.camera.height, c.camera.fx, c.camera.fy, c.camera.cx, c.camera.cy, c.depth_scale, c.readout,
      c.exposure, c.exposure_samples, c.noise, n.axial, n.lateral, n.baseline, n.focal_length, n.disparity_step,
      n.correlation, n.distortion, n.min_range, n.max_range, degrees(n.grazing_start), degrees(n.grazing_end),
      n.edge_holes, n.signal, n.shadow);
}

std::string sensor_toml(const sim::OrientationSensorOptions& o) {
  const Eigen::Quaterniond q(o.body_from_camera);
  return fmt::format(
      "[orientation_sensor]\nseed = {}\nrate = {:.9g}  # Hz\nlatency = {:.9g}  # s\nclock_offset = {:.9g}  # s\n"
      "clock_drift = {:.9g}  # s per s\nbody_from_camera = [{:.9g}, {:.9g}, {:.9g}, {:.9g}]  # qx qy qz qw\n"
      "lever_arm = {}  # m, camera frame\ntilt_error_deg = {:.9g}\nheading_error_deg = {:.9g}\nharmonics = {}\n"
      "orientation_noise_deg = {:.9g}\ngyroscope_noise = {:.9g}  # rad/s\ngyroscope_bias = {:.9g}  # rad/s\n"
      "gyroscope_bias_walk = {:.9g}  # rad/s per √s\naccelerometer_noise = {:.9g}  # m/s²\n"
      "magnetometer_noise = {:.9g}  # µT\ndisturbance = {}  # µT, east north up\n"
      "disturbance_begin = {:.9g}  # s\ndisturbance_end = {:.9g}  # s\n",
      o.seed, o.rate, o.latency, o.clock_offset, o.clock_drift, q.x(), q.y(), q.z(), q.w(), numbers(o.lever_arm),
      degrees(o.tilt_error), degrees(o.heading_error), o.harmonics, degrees(o.orientation_noise), o.gyroscope_noise,
      o.gyroscope_bias, o.gyroscope_bias_walk, o.accelerometer_noise, o.magnetometer_noise, numbers(o.disturbance),
      o.disturbance_begin, o.disturbance_end);
}

std::string scene_toml(const SimulatedSequence& s) {
  return fmt::format(
             "# How this sequence was made: `plumbline simulate` with these values gives the same bytes.\n"
             "scene = {}\nseed = {}\nfirst_stamp = {}\n\n",
             toml_string(s.scene), s.seed, format_seconds(s.start)) +
         motion_toml(s) + camera_toml(s.camera) + sensor_toml(s.sensor);
}

void write_images(const fs::path& folder, const Mesh& mesh, const SimulatedSequence& sequence) {
  ensure_directory((folder / "depth").string());
  if (sequence.camera.color) ensure_directory((folder / "rgb").string());
  const sim::DepthCamera camera(mesh, sequence.camera);
  tbb::parallel_for(0, sequence.frames, [&](int i) {
    const Frame frame = camera.capture(sequence.world_from_camera, i / sequence.rate, i);
    const Nanoseconds time = frame_time(sequence, i);
    write_depth_png((folder / image_name("depth", time)).string(), frame.depth);
    if (sequence.camera.color) write_color_png((folder / image_name("rgb", time)).string(), frame.color);
  });
}

bool is_one_of(const std::string& name, const std::vector<std::string>& names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

sim::Scene load_scene(const std::string& name) {
  if (!is_one_of(name, sim::scene_names()) && fs::exists(name)) return sim::scene_of(name, read_mesh(name));
  return sim::make_scene(name);  // throws, naming the known ones
}

sim::Motion choose_motion(const sim::PathOptions& path, const sim::Scene& scene, const PathPlacement& placement,
                          SimulatedSequence* sequence) {
  const bool made_up = is_one_of(sequence->trajectory, sim::path_kinds());
  if (!made_up && !fs::exists(sequence->trajectory))
    throw Error("there is no such path and no such file", "--trajectory " + sequence->trajectory,
                "Take orbit, sweep, handheld, turntable, dance, walk, or a file in TUM's format.");
  sim::Smoothing smoothing;
  const sim::Motion motion = made_up ? sim::make_path(sequence->trajectory, scene, path)
                                     : sim::smooth_motion(read_trajectory(sequence->trajectory), 0.06, &smoothing);
  if (!made_up) sequence->smoothing = smoothing;
  sequence->placement = sim::judge(motion, scene, placement.scene_from_path.value_or(SE3()));
  // A made-up path is where it should be, unless the scene is too narrow for it.
  if (!placement.scene_from_path && (!made_up || sequence->placement.clearance < 0.05))
    sequence->placement = sim::place(motion, scene, placement.clearance);
  return motion.placed(sequence->placement.scene_from_recorded).faster(sequence->speed);
}

Pinhole kinect(int width, int height) {
  const float focal_length = 525.0f * static_cast<float>(width) / 640.0f;
  return {focal_length, focal_length, 0.5f * static_cast<float>(width - 1), 0.5f * static_cast<float>(height - 1),
          width,        height};
}

Nanoseconds frame_time(const SimulatedSequence& sequence, int index) {
  return sequence.start + 1000 * static_cast<Nanoseconds>(std::llround(1e6 * index / sequence.rate));
}

Trajectory true_trajectory(const SimulatedSequence& sequence) {
  Trajectory poses;
  for (int i = 0; i < sequence.frames; ++i)
    poses.push_back({frame_time(sequence, i), sequence.world_from_camera(i / sequence.rate)});
  return poses;
}

double write_simulated_sequence(const std::string& path, const Mesh& mesh, const SimulatedSequence& sequence) {
  const fs::path folder(path);
  ensure_directory(path);
  // An older list names images that are about to be replaced; without one the folder is no sequence until all is done.
  for (const char* list : {"depth.txt", "rgb.txt"}) {
    std::error_code ignored;
    fs::remove(folder / list, ignored);
  }
  const auto begin = std::chrono::steady_clock::now();
  write_images(folder, mesh, sequence);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();

  const Trajectory poses = true_trajectory(sequence);
  write_camera_json(path, sequence.camera.camera, sequence.camera.depth_scale, sequence.sensor.body_from_camera);
  write_tum_trajectory((folder / "groundtruth.txt").string(), poses);
  const std::vector<sim::InertialSample> samples =
      sim::simulate_sensor(sequence.world_from_camera, sequence.duration, sequence.start, sequence.sensor);
  write_orientations((folder / "orientation.txt").string(), orientations(samples));
  write_imu((folder / "imu.csv").string(), imu_recording(samples));
  write_ply((folder / "scene.ply").string(), mesh);
  write_file((folder / "scene.toml").string(), scene_toml(sequence));
  if (sequence.camera.color) write_file((folder / "rgb.txt").string(), image_list("rgb", poses));
  write_file((folder / "depth.txt").string(), image_list("depth", poses));  // last: with it the folder is a sequence
  return seconds;
}

}  // namespace plumbline
