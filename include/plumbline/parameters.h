// Every parameter of the reconstruction, listed once: name, place, unit, help and permitted range.
//
// The `fields()` visitor of each group drives the TOML file, `--set`, `--print-config`, the copy saved beside results
// and later the Python attributes. To add a parameter: add a member with its default and one line in `fields()`.
#pragma once

#include <array>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "plumbline/angles.h"
#include "plumbline/export.h"

namespace plumbline {

/// Closed interval of permitted values.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
};

enum class VolumePlacement { follow, front, fit, given };
constexpr auto names(VolumePlacement) { return std::array<std::string_view, 4>{"follow", "front", "fit", "given"}; }

enum class OrientationSeed { none, absolute, relative };
constexpr auto names(OrientationSeed) { return std::array<std::string_view, 3>{"none", "absolute", "relative"}; }

enum class OrientationTerm { none, damping, anchor };
constexpr auto names(OrientationTerm) { return std::array<std::string_view, 3>{"none", "damping", "anchor"}; }

enum class LambdaSchedule { constant, inverse_sqrt, inverse, inverse_square, negative_log };
constexpr auto names(LambdaSchedule) {
  return std::array<std::string_view, 5>{"constant", "inverse_sqrt", "inverse", "inverse_square", "negative_log"};
}

/// An angle that people write in degrees and the code reads in radians: this is the one conversion.
struct Angle {
  double degrees = 0;
  constexpr Angle(double in_degrees) : degrees(in_degrees) {}  // NOLINT: parameters are assigned plain numbers
  constexpr double radians() const { return plumbline::radians(degrees); }
  constexpr bool operator==(const Angle&) const = default;
};

struct PreprocessParameters {
  bool calibrate_depth = true;
  double min_depth = 0.3;
  double max_depth = 8.0;
  bool bilateral = false;
};

struct TrackingParameters {
  // Association: which pairs are used, and what each weighs.
  int finest_level = 1;
  double distance_gate = 0.10;
  double gate_per_median = 5;
  Angle normal_gate = 30;
  bool median_filter = false;
  double median_band = 0.10;
  bool depth_weights = true;
  double huber = 0.01;
  double redundancy = 200;
  // Convergence: how long a level iterates.
  std::vector<int> iterations = {2, 2, 3};
  double converged_step = 0.0005;
  int max_iterations = 10;
  int converged_after = 0;
  // Plausibility: what is accepted, and what is tried where it is not.
  double min_inlier_fraction = 0.01;  ///< a turn of 50° leaves no more in common
  double min_matched = 0.15;
  double max_step_translation = 0.30;
  Angle max_step_rotation = 30;
  Angle search = 7;
  // Motion: what is expected of the camera.
  double speed_sigma = 0.75;
  double speed_memory = 0.3;
  // After an interruption.
  double relocalise_after = 0.25;
};

struct OrientationParameters {
  OrientationSeed seed = OrientationSeed::relative;
  OrientationTerm term = OrientationTerm::anchor;
  LambdaSchedule schedule = LambdaSchedule::inverse_sqrt;
  double lambda = 2;
  Angle tilt_sigma = 3;
  Angle heading_sigma = 10;
  Angle search = 4;
  double distrust = 0.5;
};

struct MotionParameters {
  bool steady = true;
  bool gyroscope = true;
  bool accelerometer = true;
  double correlation_time = 1.5;
  double acceleration_sigma = 0.05;
};

struct VolumeParameters {
  int resolution = 512;
  double side = 8.0;
  VolumePlacement placement = VolumePlacement::follow;
  double offset = -0.5;
  std::vector<double> pose = {0, 0, 0, 0, 0, 0, 1};
  double truncation = 0.08;
  int max_weight = 128;
  bool color = true;
};

struct MeshParameters {
  int min_weight = 3;
};

/// All of them. A default-constructed value is the preset `plumbline`: docs/method.md §6, points 1 to 5, with what
/// recorded and simulated sequences called for besides (docs/results.md): a redundancy of 200 and not 10⁴, and a prior
/// that goes on with the velocity that was seen, else the camera lags behind wherever the scene is some metres away;
/// iterations until the step is small and a gate that follows the distances, for fast motion; a volume that reaches as
/// far around the camera as the sensor sees.
struct Parameters {
  PreprocessParameters preprocess;
  TrackingParameters tracking;
  OrientationParameters orientation;
  MotionParameters motion;
  VolumeParameters volume;
  MeshParameters mesh;
};

template <class P, class Visitor>
void preprocess_fields(P& p, Visitor&& v) {
  v("calibrate_depth", p.calibrate_depth, "",
    "before a recorded sequence is run, find from it the distortion of the depth, and undistort", Range{});
  v("min_depth", p.min_depth, "m", "readings nearer than this are ignored", Range{0, 100});
  v("max_depth", p.max_depth, "m", "readings farther than this are ignored", Range{0, 100});
  v("bilateral", p.bilateral, "", "smooth the depth that is tracked (the fused depth stays raw)", Range{});
}

template <class P, class Visitor>
void tracking_fields(P& p, Visitor&& v) {
  // Association
  v("finest_level", p.finest_level, "", "pyramid level of the last entry of iterations; 0 is full resolution",
    Range{0, 6});
  v("distance_gate", p.distance_gate, "m", "pairs farther apart are not used", Range{1e-4, 10});
  v("gate_per_median", p.gate_per_median, "1",
    "the distance gate widens to so many times the previous iteration's median distance, up to 0.3 m; 0: it does not",
    Range{0, 1000});
  v("normal_gate", p.normal_gate.degrees, "deg", "pairs whose normals differ more are not used", Range{0.1, 180});
  v("median_filter", p.median_filter, "", "use only pairs near the median distance of the same iteration", Range{});
  v("median_band", p.median_band, "m", "half width of the band around the median", Range{1e-4, 10});
  v("depth_weights", p.depth_weights, "", "weight pairs by the depth's axial noise (Nguyen 2012), 1 at 1.5 m", Range{});
  v("huber", p.huber, "m", "residuals beyond this count linearly (Huber); 0: never", Range{0, 10});
  v("redundancy", p.redundancy, "1",
    "pixels of a 320x240 image that tell no more than one, as neighbours are not independent: divides the "
    "registration's information beside priors",
    Range{1, 1e9});
  // Convergence
  v("iterations", p.iterations, "", "ICP iterations per pyramid level, coarse to fine", Range{0, 1000});
  v("converged_step", p.converged_step, "m",
    "a level goes on beyond its iterations until a step moves what is 1.5 m away by less than this; 0: never",
    Range{0, 1});
  v("max_iterations", p.max_iterations, "", "but makes no more than these", Range{1, 1000});
  v("converged_after", p.converged_after, "iterations",
    "a level ends when the median's bin has not changed for so many successive iterations; 0: never early",
    Range{0, 1000});
  // Plausibility
  v("min_inlier_fraction", p.min_inlier_fraction, "1", "fewer matched pixels with depth than this: lost", Range{0, 1});
  v("min_matched", p.min_matched, "1", "fewer matched pixels of those that meet the model than this: lost",
    Range{0, 1});
  v("max_step_translation", p.max_step_translation, "m", "a longer step between frames is implausible: lost",
    Range{1e-3, 1e3});
  v("max_step_rotation", p.max_step_rotation.degrees, "deg", "a larger turn between frames is implausible: lost",
    Range{0.1, 180});
  v("search", p.search.degrees, "deg",
    "where images and model disagree ICP also starts from turns so far apart, without a sensor; 0: it does not",
    Range{0, 180});
  // Motion
  v("speed_sigma", p.speed_sigma, "m/s", "prior on the camera's motion: usual speed along each axis; 0: none",
    Range{0, 1e3});
  v("speed_memory", p.speed_memory, "s",
    "the motion that was seen is expected to go on: the velocity for about so long, the turn until the next frame; 0: "
    "the camera is expected to stand still",
    Range{0, 1e3});
  // After an interruption
  v("relocalise_after", p.relocalise_after, "s",
    "after longer than this, and than usual, without an accepted frame the place must be recognised among those that "
    "were mapped; 0: the usual tests are enough",
    Range{0, 1e3});
}

template <class P, class Visitor>
void orientation_fields(P& p, Visitor&& v) {
  v("seed", p.seed, "",
    "where ICP's rotation starts: none (previous pose), absolute (the sensor's), relative (previous pose "
    "turned by the sensor's change)",
    Range{});
  v("term", p.term, "", "none; damping of each step by lambda; anchor: the sensor's reading with its covariance",
    Range{});
  v("schedule", p.schedule, "", "lambda over the matched fraction f: c, c/sqrt(f), c/f, c/f^2 or -c ln f", Range{});
  v("lambda", p.lambda, "1", "c of the schedule", Range{0, 1e9});
  v("tilt_sigma", p.tilt_sigma.degrees, "deg", "anchor: standard deviation about each horizontal axis",
    Range{1e-3, 360});
  v("heading_sigma", p.heading_sigma.degrees, "deg", "anchor: standard deviation about the vertical", Range{1e-3, 360});
  v("search", p.search.degrees, "deg",
    "after a large turn ICP also starts from headings so far apart, as far as the sensor's may be wrong; 0: it does "
    "not",
    Range{0, 180});
  v("distrust", p.distrust, "1",
    "the sensor is not used while its turns miss the tracked ones by more than this part of their square; 0: always "
    "used",
    Range{0, 100});
}

template <class P, class Visitor>
void motion_fields(P& p, Visitor&& v) {
  v("steady", p.steady, "", "without a sensor, predict each frame by a filter that expects steady motion", Range{});
  v("gyroscope", p.gyroscope, "", "where there is a gyroscope, predict each frame from its readings", Range{});
  v("accelerometer", p.accelerometer, "", "and from those of its accelerometer", Range{});
  v("correlation_time", p.correlation_time, "s",
    "over which successive registrations err alike: divides the images' information beside a gyroscope", Range{0, 100});
  v("acceleration_sigma", p.acceleration_sigma, "m/s/sqrt(s)", "random walk of the velocity beside the accelerometer",
    Range{1e-4, 100});
}

template <class P, class Visitor>
void volume_fields(P& p, Visitor&& v) {
  v("resolution", p.resolution, "voxels", "voxels along each side; rounded up to a multiple of 8", Range{8, 1024});
  v("side", p.side, "m", "length of each side", Range{0.01, 1000});
  v("placement", p.placement, "",
    "front: centred on the first camera's axis, offset*side in front of it; follow: begins there and moves with the "
    "camera, what it leaves is kept; fit: around the first frame's points, at most side; given: by pose",
    Range{});
  v("offset", p.offset, "side",
    "placements front and follow: front face in front of the camera; negative: the camera stands inside the volume",
    Range{-2, 2});
  v("pose", p.pose, "m", "placement given: the volume's lowest corner in the world, [tx, ty, tz, qx, qy, qz, qw]",
    Range{-1e6, 1e6});
  v("truncation", p.truncation, "m", "truncation distance of the signed distance", Range{1e-4, 10});
  v("max_weight", p.max_weight, "", "cap of the running average's weight", Range{1, 65535});
  v("color", p.color, "", "fuse colour where the sequence has it (4 more bytes a voxel)", Range{});
}

template <class P, class Visitor>
void mesh_fields(P& p, Visitor&& v) {
  v("min_weight", p.min_weight, "",
    "cells with a voxel seen fewer times give no surface (never more than the frames fused)", Range{1, 65535});
}

/// Calls `v(name, member, unit, help, Range)` for each field, between `v.group(name)` calls.
template <class P, class Visitor>
void fields(P& p, Visitor&& v) {
  v.group("preprocess");
  preprocess_fields(p.preprocess, v);
  v.group("tracking");
  tracking_fields(p.tracking, v);
  v.group("orientation");
  orientation_fields(p.orientation, v);
  v.group("motion");
  motion_fields(p.motion, v);
  v.group("volume");
  volume_fields(p.volume, v);
  v.group("mesh");
  mesh_fields(p.mesh, v);
}

/// The presets by name: `plumbline`, `paper`, `kinectfusion`. Throws Error naming the known ones.
PLUMBLINE_EXPORT Parameters preset(std::string_view name);
PLUMBLINE_EXPORT std::vector<std::string> preset_names();

/// What preset `plumbline` does with more or less time (docs/results.md): `fast` tracks at a quarter of the pixels in
/// coarser voxels, `balanced` is the preset as it is, `best` has finer voxels. Throws Error naming the known ones.
PLUMBLINE_EXPORT void apply_quality(std::string_view name, Parameters* parameters);
PLUMBLINE_EXPORT std::vector<std::string> quality_names();

}  // namespace plumbline
