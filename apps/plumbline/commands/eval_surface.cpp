#include "commands/eval_surface.h"

#include <CLI/CLI.hpp>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cli/arguments.h"
#include "cli/console.h"
#include "commands/error_color.h"
#include "io/mesh.h"
#include "io/trajectory.h"
#include "plumbline/error.h"
#include "plumbline/evaluation.h"
#include "plumbline/mesh.h"
#include "plumbline/se3.h"
#include "plumbline/sequence.h"
#include "plumbline/surface_error.h"
#include "plumbline/trajectory.h"
#include "sim/visibility.h"

namespace plumbline::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct SurfaceArguments {
  std::string mesh, reference, trajectory, alignment, groundtruth, sequence, error_mesh;
  std::vector<double> thresholds = {0.01, 0.02, 0.05};
  double color_range = 0.02, max_depth = 4;
  int samples = 200'000;
  bool whole = false, json = false;
};

void move_mesh(Mesh* mesh, const SE3& to_from_mesh) {
  for (Mesh::Float3& p : mesh->positions) {
    const Eigen::Vector3f q = (to_from_mesh * Eigen::Vector3d(p.x, p.y, p.z)).cast<float>();
    p = {q.x(), q.y(), q.z()};
  }
  for (Mesh::Float3& n : mesh->normals) {
    const Eigen::Vector3f m = (to_from_mesh.rotation() * Eigen::Vector3d(n.x, n.y, n.z)).cast<float>();
    n = {m.x(), m.y(), m.z()};
  }
}

/// The folder of the sequence that shows the reference: as given, or where the reference lies.
std::string sequence_folder(const SurfaceArguments& arguments) {
  if (!arguments.sequence.empty()) return arguments.sequence;
  const fs::path folder = fs::path(arguments.reference).parent_path();
  return fs::exists(folder / "depth.txt") && fs::exists(folder / "groundtruth.txt") ? folder.string() : "";
}

/// Mean over the poses of true_from_estimated. Positions alone, as the trajectory error is aligned by, would leave the
/// rotation open on a short or straight path. Rotations are averaged by their matrices (Moakher 2002).
SE3 mean_alignment(const Trajectory& truth, const Trajectory& estimate) {
  const std::vector<eval::Association> pairs = eval::associate(truth, estimate);
  if (pairs.empty())
    throw Error("no pose has a stamp of the true trajectory", "eval surface", "Give the trajectory of this sequence.");
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  Eigen::Vector3d mean_true = Eigen::Vector3d::Zero(), mean_estimate = mean_true;
  for (const eval::Association& pair : pairs) {
    const SE3 &t = truth[pair.reference].world_from_camera, &e = estimate[pair.estimate].world_from_camera;
    sum += t.rotation() * e.rotation().transpose();
    mean_true += t.translation() / static_cast<double>(pairs.size());
    mean_estimate += e.translation() / static_cast<double>(pairs.size());
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d proper = Eigen::Matrix3d::Identity();
  proper(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  const Eigen::Matrix3d rotation = svd.matrixU() * proper * svd.matrixV().transpose();
  return {rotation, mean_true - rotation * mean_estimate};
}

/// reference_from_mesh: given, or what brings the run's trajectory onto the true one; the meshes' frames are the same
/// otherwise.
SE3 alignment(const SurfaceArguments& arguments) {
  if (!arguments.alignment.empty()) return parse_pose(arguments.alignment, "--alignment");
  if (arguments.trajectory.empty()) return {};
  std::string truth = arguments.groundtruth;
  if (truth.empty()) {
    const std::string folder = sequence_folder(arguments);
    if (folder.empty())
      throw UsageError("there is no true trajectory beside the reference", "--trajectory",
                       "Give it with --groundtruth FILE.");
    truth = (fs::path(folder) / "groundtruth.txt").string();
  }
  return mean_alignment(read_trajectory(truth), read_trajectory(arguments.trajectory));
}

/// Keeps those points of the reference that the sequence's camera has seen; all where there is no sequence.
eval::PointCloud seen_part(const SurfaceArguments& arguments, const Mesh& reference, eval::PointCloud points) {
  constexpr std::size_t kMaxViews = 100;
  constexpr double kNearest = 0.4;  // metres, as a structured-light sensor sees
  const std::string folder = arguments.whole ? "" : sequence_folder(arguments);
  if (folder.empty()) return points;
  const SequenceInfo info = open_sequence(folder)->info();
  const Trajectory all = read_trajectory(arguments.groundtruth.empty() ? info.groundtruth : arguments.groundtruth);
  Trajectory poses;
  const std::size_t step = std::max<std::size_t>(1, all.size() / kMaxViews);
  for (std::size_t i = 0; i < all.size(); i += step) poses.push_back(all[i]);
  const std::vector<bool> seen = sim::seen_points(reference, points, info.camera, poses, kNearest, arguments.max_depth);
  eval::PointCloud kept;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (seen[i]) kept.push_back(points[i]);
  return kept;
}

void write_error_mesh(const SurfaceArguments& arguments, Mesh mesh, const Mesh& reference) {
  const std::vector<double> distances = eval::distances_to_mesh(mesh.positions, reference);
  mesh.colors.clear();
  for (const double d : distances) mesh.colors.push_back(error_color(d, arguments.color_range));
  write_mesh(arguments.error_mesh, mesh);
}

Json to_json(const eval::Statistics& s) {
  return {{"points", s.count}, {"mean", s.mean}, {"median", s.median}, {"rmse", s.rmse}, {"max", s.max}};
}

void print_json(const eval::SurfaceError& error) {
  Json json;
  json["accuracy_m"] = to_json(error.accuracy);
  json["completeness_m"] = to_json(error.completeness);
  json["scores"] = Json::array();
  for (const eval::SurfaceScore& s : error.scores)
    json["scores"].push_back(
        {{"threshold_m", s.threshold}, {"precision", s.precision}, {"recall", s.recall}, {"f_score", s.f_score}});
  say(json.dump(2));
}

void print_text(const eval::SurfaceError& error, bool seen_only) {
  const auto line = [](const char* name, const eval::Statistics& s) {
    say("{:<13} mean {:.2f}  median {:.2f}  rmse {:.2f}  max {:.1f}  mm", name, 1e3 * s.mean, 1e3 * s.median,
        1e3 * s.rmse, 1e3 * s.max);
  };
  say("distances between the surfaces{}", seen_only ? "; completeness over what the camera has seen" : "");
  line("accuracy", error.accuracy);
  line("completeness", error.completeness);
  for (const eval::SurfaceScore& s : error.scores)
    say("within {:>4.0f} mm  precision {:.1f} %  recall {:.1f} %  F-score {:.1f} %", 1e3 * s.threshold,
        100 * s.precision, 100 * s.recall, 100 * s.f_score);
}

int evaluate_surface(const SurfaceArguments& arguments) {
  Mesh mesh = read_mesh(arguments.mesh);
  const Mesh reference = read_mesh(arguments.reference);
  move_mesh(&mesh, alignment(arguments));
  const auto samples = static_cast<std::size_t>(arguments.samples);
  const eval::PointCloud on_mesh = eval::sample_surface(mesh, samples);
  const eval::PointCloud on_reference = seen_part(arguments, reference, eval::sample_surface(reference, samples));
  const eval::SurfaceError error = eval::surface_error(
      eval::distances_to_mesh(on_mesh, reference), eval::distances_to_mesh(on_reference, mesh), arguments.thresholds);
  if (!arguments.error_mesh.empty()) write_error_mesh(arguments, std::move(mesh), reference);
  if (arguments.json)
    print_json(error);
  else
    print_text(error, !arguments.whole && !sequence_folder(arguments).empty());
  return 0;
}

}  // namespace

void add_eval_surface(CLI::App& eval, Command& chosen) {
  const auto a = std::make_shared<SurfaceArguments>();
  CLI::App* command = eval.add_subcommand("surface", "Distances between a mesh and the true surface");
  command->add_option("mesh", a->mesh, "Reconstruction, PLY or OBJ")->required()->type_name("MESH");
  command->add_option("reference", a->reference, "True surface, PLY or OBJ")->required()->type_name("REFERENCE");
  command
      ->add_option("--trajectory", a->trajectory,
                   "The run's trajectory: the mesh is moved by what brings this onto the true one")
      ->type_name("FILE");
  command->add_option("--groundtruth", a->groundtruth, "True trajectory (default: that beside the reference)")
      ->type_name("FILE");
  command->add_option("--alignment", a->alignment, "reference_from_mesh, in place of --trajectory")
      ->type_name("\"TX TY TZ QX QY QZ QW\"");
  command
      ->add_option("--sequence", a->sequence,
                   "Sequence whose views limit completeness to what was seen (default: the reference's folder)")
      ->type_name("DIR");
  command->add_flag("--whole", a->whole, "Completeness over the whole reference, seen or not");
  command->add_option("--max-depth", a->max_depth, "Metres within which a surface counts as seen")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--thresholds", a->thresholds, "Metres, for precision, recall and F-score")
      ->delimiter(',')
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--samples", a->samples, "Points on each surface")
      ->check(CLI::Range(100, 100'000'000))
      ->capture_default_str();
  command
      ->add_option("--error-mesh", a->error_mesh, "Write the mesh painted by its error: green none, red --color-range")
      ->type_name("FILE");
  command->add_option("--color-range", a->color_range, "Metres that are red in --error-mesh")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_flag("--json", a->json, "Print JSON");
  command->callback([a, &chosen] { chosen = [a] { return evaluate_surface(*a); }; });
}

}  // namespace plumbline::app
