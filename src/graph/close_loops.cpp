#include "graph/close_loops.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "graph/loops.h"
#include "graph/odometry.h"
#include "graph/pose_graph.h"
#include "place/keyframes.h"

namespace plumbline {
namespace {

constexpr double kStep = 0.25;                          // radians, 1.5 m as one, between views
constexpr std::size_t kLinked = 2;                      // next views that each one is registered to
constexpr std::size_t kMaxViews = 2000;                 // more of them lie farther apart
constexpr double kRobustOdometry = 3, kRobustLoop = 4;  // standard deviations
constexpr std::size_t kMinLoops = 3;                    // that confirm one another
constexpr double kLookAgain = 0.1;                      // as kStep: views that were moved by more show other loops
constexpr double kDrift = 1.4;                          // χ² a direction; what registration alone disagrees by is 1
constexpr double kPays = 0.5;                           // of it that may be left in loops that were held back
constexpr double kMaxCounted = 25;                      // χ² a direction of one loop

/// A path with the views that it is corrected by.
struct Scene {
  std::vector<PathView> views;
  std::vector<std::optional<ViewEdge>> neighbours;  ///< of each view with the next one
  std::vector<ViewEdge> links;                      ///< registrations of views that follow each other that stand alone
  double scale = 1;
  std::vector<TriedLoop> loops;
};

std::vector<std::size_t> choose_views(const std::vector<PathFrame>& path) {
  double step = kStep;
  std::vector<std::size_t> chosen = spaced_frames(path, step);
  while (chosen.size() > kMaxViews) chosen = spaced_frames(path, step *= 1.5);
  return chosen;
}

/// Each view to the next ones: how far the path can be trusted, and, with others than the tracker's model, where it
/// went.
void register_neighbours(ViewMatcher* matcher, const std::function<bool()>& stopping, Scene* scene) {
  std::vector<ViewEdge> all;
  for (std::size_t i = 0; i + 1 < scene->views.size(); ++i) {
    if (stopping && stopping()) return;
    for (std::size_t j = i + 1; j < scene->views.size() && j <= i + kLinked; ++j) {
      if (scene->views[i].piece != scene->views[j].piece) continue;
      const std::optional<ViewEdge> edge = matcher->match(scene->views, i, j, Reach::near);
      if (j == i + 1) scene->neighbours.push_back(edge);
      if (edge) all.push_back(*edge);
    }
    scene->neighbours.resize(i + 1);
  }
  scene->scale = covariance_scale(scene->views, scene->neighbours);
  for (const ViewEdge& edge : all)
    if (judge_alone(edge, scene->scale) == LoopStatus::accepted) scene->links.push_back(edge);
}

PoseConstraint constraint_of(const ViewEdge& edge, double scale, double robust) {
  return {edge.first, edge.second, edge.motion.first_from_second, scale * edge.motion.covariance, robust};
}

std::vector<PoseConstraint> accepted_loops(const Scene& scene) {
  std::vector<PoseConstraint> loops;
  for (const TriedLoop& loop : scene.loops)
    if (loop.status == LoopStatus::accepted) loops.push_back(constraint_of(*loop.edge, scene.scale, kRobustLoop));
  return loops;
}

/// Up in the world is the mean over the path as it was tracked: what a sensor is wrong by all the time stays out.
void add_ups(const Scene& scene, double sigma, PoseGraph* graph) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const PathView& view : scene.views)
    if (view.up) sum += view.world_from_camera.rotation() * *view.up;
  if (!(sum.norm() > 0)) return;
  for (std::size_t i = 0; i < scene.views.size(); ++i)
    if (scene.views[i].up) graph->ups.push_back({i, *scene.views[i].up, sum.normalized(), sigma});
}

PoseGraph path_graph(const Scene& scene, const Odometry& odometry, double tilt_sigma) {
  PoseGraph graph;
  for (const PathView& view : scene.views) graph.world_from_node.push_back(view.world_from_camera);
  for (std::size_t i = 0; i + 1 < scene.views.size(); ++i) {
    const std::optional<ViewEdge>& edge = scene.neighbours[i];
    const bool is_registered = edge && judge_alone(*edge, scene.scale) == LoopStatus::accepted;
    const RelativePose& tracked = odometry.steps()[i];
    graph.constraints.push_back({i, i + 1, tracked.first_from_second,
                                 is_registered ? Matrix6d(scene.scale * edge->motion.covariance) : tracked.covariance,
                                 kRobustOdometry});
  }
  for (const ViewEdge& link : scene.links)
    graph.constraints.push_back(constraint_of(link, scene.scale, kRobustOdometry));
  add_ups(scene, tilt_sigma, &graph);
  return graph;
}

void move_views(const std::vector<SE3>& world_from_view, Scene* scene) {
  for (std::size_t i = 0; i < world_from_view.size(); ++i) scene->views[i].world_from_camera = world_from_view[i];
}

std::optional<std::vector<SE3>> solve_with(PoseGraph graph, const std::vector<PoseConstraint>& loops) {
  graph.constraints.insert(graph.constraints.end(), loops.begin(), loops.end());
  return optimise(graph);
}

double disagreement(const std::vector<PoseConstraint>& loops, const std::vector<SE3>& poses) {
  double sum = 0;
  for (const PoseConstraint& loop : loops) sum += std::min(squared_error(loop, poses) / 6, kMaxCounted);
  return loops.empty() ? 0 : sum / static_cast<double>(loops.size());
}

/// Of loops that had no part in the correction, what is left of their disagreement by it: each half by the other.
double left_over(const PoseGraph& graph, const std::vector<PoseConstraint>& loops) {
  double before = 0, after = 0;
  for (std::size_t half = 0; half < 2; ++half) {
    std::vector<PoseConstraint> used, held_back;
    for (std::size_t i = 0; i < loops.size(); ++i) (i % 2 == half ? used : held_back).push_back(loops[i]);
    const auto poses = solve_with(graph, used);
    if (!poses) return 1;
    before += disagreement(held_back, graph.world_from_node);
    after += disagreement(held_back, *poses);
  }
  return before > 0 ? after / before : 1;
}

/// Why the path is left as it is; empty if it is not.
std::string refusal(const PoseGraph& graph, const std::vector<PoseConstraint>& loops, GlobalCorrection correction,
                    const LoopClosure& report) {
  if (loops.empty()) return report.loops.empty() ? "no place was seen twice" : "no loop was accepted";
  if (correction == GlobalCorrection::on) return "";
  if (loops.size() < kMinLoops) return "there are too few loops to confirm one another";
  if (report.disagreement_before < kDrift) return "the path agrees with its loops";
  if (left_over(graph, loops) > kPays) return "loops that were held back would not agree better";
  return "";
}

/// Loops that were too far from their views' poses to be found are looked for again where the first ones put the views.
void look_again(const Odometry& odometry, const Parameters& parameters, ViewMatcher* matcher,
                const std::function<bool()>& stopping, Scene* scene) {
  const std::vector<PoseConstraint> loops = accepted_loops(*scene);
  if (loops.empty()) return;
  const PoseGraph graph = path_graph(*scene, odometry, parameters.orientation.tilt_sigma.radians());
  const std::optional<std::vector<SE3>> poses = solve_with(graph, loops);
  double moved = 0;
  for (std::size_t i = 0; poses && i < poses->size(); ++i)
    moved = std::max(moved, pose_distance((*poses)[i], scene->views[i].world_from_camera));
  if (moved < kLookAgain) return;
  move_views(*poses, scene);
  find_loops(scene->views, odometry, scene->scale, matcher, stopping, &scene->loops);
  move_views(graph.world_from_node, scene);
}

std::vector<LoopReport> reports(const Scene& scene, const std::vector<PathFrame>& path) {
  std::vector<LoopReport> all;
  for (const TriedLoop& loop : scene.loops) {
    const PathView &first = scene.views[loop.pair.first], &second = scene.views[loop.pair.second];
    LoopReport report{path[first.frame].index, path[second.frame].index, loop.status, {}};
    if (loop.edge) {
      report.first_from_second = loop.edge->motion.first_from_second;
      const Vector6d d =
          constraint_residual(first.world_from_camera, second.world_from_camera, loop.edge->motion.first_from_second);
      report.rotation = d.head<3>().norm();
      report.translation = d.tail<3>().norm();
    }
    all.push_back(report);
  }
  return all;
}

void measure_correction(const std::vector<PathFrame>& path, const std::vector<SE3>& corrected, LoopClosure* report) {
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Vector6d d = pose_difference(corrected[i], path[i].world_from_camera);
    report->max_rotation = std::max(report->max_rotation, d.head<3>().norm());
    report->max_translation = std::max(report->max_translation, d.tail<3>().norm());
  }
}

void correct(const Scene& scene, const Odometry& odometry, const std::vector<PathFrame>& path,
             const Parameters& parameters, GlobalCorrection correction, ClosedLoops* closed) {
  LoopClosure& report = closed->report;
  const std::vector<PoseConstraint> loops = accepted_loops(scene);
  const PoseGraph graph = path_graph(scene, odometry, parameters.orientation.tilt_sigma.radians());
  report.disagreement_before = report.disagreement_after = disagreement(loops, graph.world_from_node);
  report.note = refusal(graph, loops, correction, report);
  if (!report.note.empty()) return;
  const std::optional<std::vector<SE3>> poses = solve_with(graph, loops);
  const double after = poses ? disagreement(loops, *poses) : report.disagreement_before;
  if (!(after < report.disagreement_before)) {
    report.note = "no path fits the loops better";
    return;
  }
  report.disagreement_after = after;
  report.is_applied = true;
  std::vector<std::size_t> frames;
  for (const PathView& view : scene.views) frames.push_back(view.frame);
  closed->world_from_camera = spread_correction(path, frames, *poses);
  measure_correction(path, closed->world_from_camera, &report);
}

void find_and_correct(const Sequence& recording, const std::vector<PathFrame>& path, const Parameters& parameters,
                      const Backend& backend, const LoopOptions& options, ClosedLoops* closed) {
  const auto interrupted = [&] { return options.stopping && options.stopping(); };
  Scene scene;
  scene.views = read_views(recording, path, choose_views(path), parameters, backend, options.stopping);
  ViewMatcher matcher(parameters, recording.info().camera, backend);
  register_neighbours(&matcher, options.stopping, &scene);
  if (interrupted()) {
    closed->report.note = "interrupted";
    return;
  }
  const Odometry odometry(scene.views, scene.neighbours, scene.scale);
  find_loops(scene.views, odometry, scene.scale, &matcher, options.stopping, &scene.loops);
  look_again(odometry, parameters, &matcher, options.stopping, &scene);
  closed->report.views = static_cast<int>(scene.views.size());
  closed->report.loops = reports(scene, path);
  if (interrupted())
    closed->report.note = "interrupted";
  else
    correct(scene, odometry, path, parameters, options.correction, closed);
}

}  // namespace

std::vector<SE3> spread_correction(const std::vector<PathFrame>& path, const std::vector<std::size_t>& frames,
                                   const std::vector<SE3>& world_from_view) {
  std::vector<Vector6d> moved;
  for (std::size_t k = 0; k < frames.size(); ++k)
    moved.push_back(pose_difference(world_from_view[k], path[frames[k]].world_from_camera));
  std::vector<double> way = {0};
  for (std::size_t i = 1; i < path.size(); ++i)
    way.push_back(way.back() + pose_distance(path[i - 1].world_from_camera, path[i].world_from_camera));

  std::vector<SE3> corrected;
  std::size_t next = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    while (next < frames.size() && frames[next] < i) ++next;
    Vector6d by = moved[std::min(next, frames.size() - 1)];
    if (next > 0 && next < frames.size()) {
      const double whole = way[frames[next]] - way[frames[next - 1]], part = way[i] - way[frames[next - 1]];
      const double share = whole > 0 ? part / whole : 1;
      by = (1 - share) * moved[next - 1] + share * moved[next];
    }
    const SE3& pose = path[i].world_from_camera;
    corrected.push_back(
        SE3(so3::exp(Eigen::Vector3d(by.head<3>())) * pose.rotation(), pose.translation() + by.tail<3>()).normalized());
  }
  return corrected;
}

ClosedLoops close_loops(const Sequence& recording, const std::vector<PathFrame>& path, const Parameters& parameters,
                        const Backend& backend, const LoopOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  ClosedLoops closed;
  if (path.size() < 2)
    closed.report.note = "the path is too short";
  else
    find_and_correct(recording, path, parameters, backend, options, &closed);
  closed.report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return closed;
}

}  // namespace plumbline
