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

namespace plumbline {

/// Closed interval of permitted values.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
};

enum class VolumePlacement { front, fit, given };
constexpr auto names(VolumePlacement) { return std::array<std::string_view, 3>{"front", "fit", "given"}; }

enum class OrientationSeed { none, absolute, relative };
constexpr auto names(OrientationSeed) { return std::array<std::string_view, 3>{"none", "absolute", "relative"}; }

enum class OrientationTerm { none, damping, anchor };
constexpr auto names(OrientationTerm) { return std::array<std::string_view, 3>{"none", "damping", "anchor"}; }

enum class LambdaSchedule { constant, inverse_sqrt, inverse, inverse_square, negative_log };
constexpr auto names(LambdaSchedule) {
  return std::array<std::string_view, 5>{"constant", "inverse_sqrt", "inverse", "inverse_square", "negative_log"};
}

struct PreprocessParameters {
  bool calibrate_depth = false;
  double min_depth = 0.3;
  double max_depth = 8.0;
  bool bilateral = true;
  int bilateral_radius = 6;
  double bilateral_sigma_space = 4.5;
  double bilateral_sigma_range = 0.03;
  double decimation_range = 0.09;
  int normal_radius = 3;
  double normal_depth_gate = 0.03;
};

struct TrackingParameters {
  std::vector<int> iterations = {4, 5, 10};
  int finest_level = 0;
  int max_iterations = 10;
  double converged_step = 0;
  double distance_gate = 0.10;
  double gate_per_median = 0;
  double widest_gate = 0.3;
  double normal_gate = 20;
  int histogram_bins = 1000;
  double histogram_range = 0.5;
  double min_inlier_fraction = 0.10;
  int min_inliers = 300;
  double min_matched = 0;
  double max_condition = 1e6;
  double max_step_translation = 0.30;
  double max_step_rotation = 30;
  double search = 0;
  bool depth_weights = false;
  double huber = 0;
  bool median_filter = false;
  double median_band = 0.10;
  int converged_after = 0;
  double speed_sigma = 0;
  double speed_memory = 0;
  bool steady_turn = false;
  double residual_sigma = 0.007;
  double redundancy = 1;
};

struct OrientationParameters {
  OrientationSeed seed = OrientationSeed::none;
  OrientationTerm term = OrientationTerm::none;
  LambdaSchedule schedule = LambdaSchedule::inverse_sqrt;
  double lambda = 2;
  double tilt_sigma = 3;
  double heading_sigma = 10;
  std::vector<double> covariance = {};
  double search = 0;
  double distrust = 0.5;
  int probation = 30;
};

struct VolumeParameters {
  int resolution = 512;
  double side = 3.0;
  VolumePlacement placement = VolumePlacement::front;
  double offset = -0.1;
  std::vector<double> pose = {0, 0, 0, 0, 0, 0, 1};
  double truncation = 0.03;
  int max_weight = 128;
  bool color = true;
};

struct RaycastParameters {
  double min_distance = 0.05;
  double max_distance = 10.0;
};

struct MeshParameters {
  int min_weight = 3;
};

/// All of them. A default-constructed value is the `kinectfusion` preset: docs/method.md §1.
struct Parameters {
  PreprocessParameters preprocess;
  TrackingParameters tracking;
  OrientationParameters orientation;
  VolumeParameters volume;
  RaycastParameters raycast;
  MeshParameters mesh;
};

template <class P, class Visitor>
void preprocess_fields(P& p, Visitor&& v) {
  v("calibrate_depth", p.calibrate_depth, "",
    "before a recorded sequence is run, find from it how the camera bends its depth, and take that out", Range{});
  v("min_depth", p.min_depth, "m", "readings nearer than this are ignored", Range{0, 100});
  v("max_depth", p.max_depth, "m", "readings farther than this are ignored", Range{0, 100});
  v("bilateral", p.bilateral, "", "smooth the depth that is tracked (the fused depth stays raw)", Range{});
  v("bilateral_radius", p.bilateral_radius, "px", "half window; 6 means 13x13", Range{1, 12});
  v("bilateral_sigma_space", p.bilateral_sigma_space, "px", "spatial standard deviation", Range{0.1, 100});
  v("bilateral_sigma_range", p.bilateral_sigma_range, "m", "depth standard deviation", Range{1e-4, 1});
  v("decimation_range", p.decimation_range, "m", "pixels within this of the nearest are averaged in the pyramid",
    Range{1e-4, 10});
  v("normal_radius", p.normal_radius, "px", "half window of the plane fit; 3 means 7x7", Range{1, 10});
  v("normal_depth_gate", p.normal_depth_gate, "1", "a neighbour belongs to the surface within this fraction of depth",
    Range{1e-4, 1});
}

template <class P, class Visitor>
void tracking_fields(P& p, Visitor&& v) {
  v("iterations", p.iterations, "", "ICP iterations per pyramid level, coarse to fine", Range{0, 1000});
  v("finest_level", p.finest_level, "", "pyramid level of the last entry of iterations; 0 is full resolution",
    Range{0, 6});
  v("converged_step", p.converged_step, "m",
    "a level goes on beyond its iterations until a step moves what is 1.5 m away by less than this; 0: never",
    Range{0, 1});
  v("max_iterations", p.max_iterations, "", "but makes no more than these", Range{1, 1000});
  v("distance_gate", p.distance_gate, "m", "pairs farther apart are not used", Range{1e-4, 10});
  v("gate_per_median", p.gate_per_median, "1",
    "the distance gate widens to so many times the last iteration's median distance; 0: it does not", Range{0, 1000});
  v("widest_gate", p.widest_gate, "m", "but no farther than this", Range{1e-4, 10});
  v("normal_gate", p.normal_gate, "deg", "pairs whose normals differ more are not used", Range{0.1, 180});
  v("histogram_bins", p.histogram_bins, "", "bins of the distance distribution; 0: none is made", Range{0, 4096});
  v("histogram_range", p.histogram_range, "m", "range of the distance distribution", Range{1e-3, 100});
  v("min_inlier_fraction", p.min_inlier_fraction, "1", "fewer matched pixels with depth than this: lost", Range{0, 1});
  v("min_inliers", p.min_inliers, "", "fewer matched pixels than this: lost", Range{6, 1e9});
  v("min_matched", p.min_matched, "1", "fewer matched pixels of those that meet the model than this: lost",
    Range{0, 1});
  v("max_condition", p.max_condition, "1", "condition number of the scaled normal equations above which: lost",
    Range{1, 1e300});
  v("max_step_translation", p.max_step_translation, "m", "a longer step between frames is implausible: lost",
    Range{1e-3, 1e3});
  v("max_step_rotation", p.max_step_rotation, "deg", "a larger turn between frames is implausible: lost",
    Range{0.1, 180});
  v("search", p.search, "deg",
    "where images and model disagree ICP also starts from turns so far apart, without a sensor; 0: it does not",
    Range{0, 180});
  v("depth_weights", p.depth_weights, "", "weight pairs by the depth's axial noise (Nguyen 2012), 1 at 1.5 m", Range{});
  v("huber", p.huber, "m", "residuals beyond this count linearly (Huber); 0: never", Range{0, 10});
  v("median_filter", p.median_filter, "", "use only pairs near the median distance of the same iteration", Range{});
  v("median_band", p.median_band, "m", "half width of the band around the median", Range{1e-4, 10});
  v("converged_after", p.converged_after, "iterations",
    "a level ends when the median's bin has not changed for so many successive iterations; 0: never early",
    Range{0, 1000});
  v("speed_sigma", p.speed_sigma, "m/s", "prior on the camera's motion: usual speed along each axis; 0: none",
    Range{0, 1e3});
  v("speed_memory", p.speed_memory, "s",
    "the velocity that was seen is expected to last about so long; 0: the camera is expected to stand still",
    Range{0, 1e3});
  v("steady_turn", p.steady_turn, "",
    "without a sensor ICP starts where the camera would be if it went on turning; else at the last pose", Range{});
  v("residual_sigma", p.residual_sigma, "m", "standard deviation of a point-to-plane residual, beside priors",
    Range{1e-5, 1});
  v("redundancy", p.redundancy, "1",
    "pixels of a 320x240 image that tell no more than one, as neighbours are not independent: divides the "
    "registration's information",
    Range{1, 1e9});
}

template <class P, class Visitor>
void orientation_fields(P& p, Visitor&& v) {
  v("seed", p.seed, "",
    "where ICP's rotation starts: none (last pose), absolute (the sensor's), relative (last pose "
    "turned by the sensor's change)",
    Range{});
  v("term", p.term, "", "none; damping of each step by lambda; anchor: the sensor's reading with its covariance",
    Range{});
  v("schedule", p.schedule, "", "lambda over the matched fraction f: c, c/sqrt(f), c/f, c/f^2 or -c ln f", Range{});
  v("lambda", p.lambda, "1", "c of the schedule", Range{0, 1e9});
  v("tilt_sigma", p.tilt_sigma, "deg", "anchor: standard deviation about each horizontal axis", Range{1e-3, 1e4});
  v("heading_sigma", p.heading_sigma, "deg", "anchor: standard deviation about the vertical", Range{1e-3, 1e4});
  v("covariance", p.covariance, "deg^2",
    "anchor: 3x3 covariance about the earth's axes (east, north, up), row by row, in place of the two sigmas; or []",
    Range{-1e8, 1e8});
  v("search", p.search, "deg",
    "after a large turn ICP also starts from headings so far apart, as far as the sensor's may be wrong; 0: it does "
    "not",
    Range{0, 180});
  v("distrust", p.distrust, "1",
    "the sensor is not used while its turns miss the tracked ones by more than this part of their square; 0: always "
    "used",
    Range{0, 100});
  v("probation", p.probation, "frames",
    "so many frames at the start are also registered without the sensor, to judge it", Range{0, 1e6});
}

template <class P, class Visitor>
void volume_fields(P& p, Visitor&& v) {
  v("resolution", p.resolution, "voxels", "voxels along each side; rounded up to a multiple of 8", Range{8, 1024});
  v("side", p.side, "m", "length of each side", Range{0.01, 1000});
  v("placement", p.placement, "",
    "front: centred on the first camera's axis, offset*side in front of it; fit: around the first frame's points, "
    "at most side; given: by pose",
    Range{});
  v("offset", p.offset, "side",
    "front face in front of the first camera; negative: the camera stands inside the volume", Range{-2, 2});
  v("pose", p.pose, "m", "placement given: the volume's lowest corner in the world, [tx, ty, tz, qx, qy, qz, qw]",
    Range{-1e6, 1e6});
  v("truncation", p.truncation, "m", "truncation distance of the signed distance", Range{1e-4, 10});
  v("max_weight", p.max_weight, "", "cap of the running average's weight", Range{1, 65535});
  v("color", p.color, "", "fuse colour where the sequence has it (4 more bytes a voxel)", Range{});
}

template <class P, class Visitor>
void raycast_fields(P& p, Visitor&& v) {
  v("min_distance", p.min_distance, "m", "surfaces nearer to the camera are not predicted", Range{1e-3, 100});
  v("max_distance", p.max_distance, "m", "surfaces farther from the camera are not predicted", Range{1e-2, 1000});
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
  v.group("volume");
  volume_fields(p.volume, v);
  v.group("raycast");
  raycast_fields(p.raycast, v);
  v.group("mesh");
  mesh_fields(p.mesh, v);
}

/// The presets by name: `plumbline`, `paper`, `kinectfusion`. Throws Error naming the known ones.
Parameters preset(std::string_view name);
std::vector<std::string> preset_names();

/// What preset `plumbline` does with more or less time (docs/results.md): `fast` tracks at a quarter of the pixels in
/// coarser voxels, `balanced` is the preset as it is, `best` has finer voxels. Throws Error naming the known ones.
void apply_quality(std::string_view name, Parameters* parameters);
std::vector<std::string> quality_names();

}  // namespace plumbline
