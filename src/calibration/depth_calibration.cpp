#include "calibration/depth_calibration.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/thread_pool.h"
#include "plumbline/angles.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"

namespace plumbline {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kMaxViews = 200, kMaxWidth = 200;  // the latter in pixels

// From each view to the first that is so far away: near ones for the slopes of the pattern, farther ones for its broad
// shape. A metre and a half turns a translation into the angle by which the scene moves in the image.
constexpr std::array<double, 4> kAway = {radians(10), radians(17), radians(25), radians(40)};
constexpr double kSceneDepth = 1.5, kMaxSeconds = 3;  // m, s
// Later ones that look at the same things again keep the views from sliding along a wall that fills a few of them.
constexpr std::size_t kRevisits = 8;
constexpr std::size_t kMinPairs = 20;
// Of more pairs than this a part stands for all (fr1/xyz has 1851). Every fifth of all is left out: it judges.
constexpr std::size_t kMaxPairs = 400, kMaxJudges = 100, kJudgeStep = 5;

// Residuals and gates in 1/m. A Kinect's noise is 0.002/m at any depth (Nguyen et al. 2012).
constexpr double kSigma = 0.003, kHuber = 2, kWideGate = 0.06, kGate = 0.03, kCosNormals = 0.87;
// Every fourth pixel of every fourth row, others in each pair: what lies between tells next to nothing new.
constexpr int kPixelStep = 4;
constexpr double kRedundancy = 25;  // points that tell no more than one: neighbours, and one thing in many pairs
constexpr std::size_t kBatch = 64;  // pairs at a time
constexpr int kMinPoints = 75;
constexpr double kMinOverlap = 0.3;
constexpr int kPoseRounds = 4, kRounds = 14;
constexpr double kConvergedStep = 1e-4;  // 1/m: a smaller step of the nodes means convergence

// What is known beforehand: 1/m, of a node, and of its second difference. Herrera et al. show patterns of some tenths
// of a pixel (a pixel is 0.023/m with a Kinect) and one or two bumps across the image.
constexpr double kNodeSigma = 0.02, kCurvatureSigma = 0.008;
// How far the given path strays in a second (and as the root of time), as `view_change`. On undistorted depth the
// tracker's own turns err by a third of it; it counts where the points say next to nothing. Distortion drags turns by
// up to a fifth: held by more than this, the distortion of simulated dances was found so wrong that mountings erred by
// 0.3°.
constexpr double kStrayUndistorted = radians(1), kStrayAsMeasured = radians(10);
constexpr double kLoose = 1;  // radians, metres: of a pose that nothing holds, as the first

struct Pose {
  const DepthCalibration::View* view;
  SE3 given, world_from_camera;
};

struct Pair {
  std::size_t first, second;  ///< of the poses
};

/// Normal equations of one pair: of its motion (left increments), of the nodes, and of both together.
struct Equations {
  explicit Equations(Index nodes)
      : coupling(MatrixXd::Zero(6, nodes)),
        grid(MatrixXd::Zero(nodes, nodes)),
        across(MatrixXd::Zero(nodes, nodes)),
        grid_gradient(VectorXd::Zero(nodes)) {}
  Matrix6d motion = Matrix6d::Zero();
  Vector6d motion_gradient = Vector6d::Zero();
  MatrixXd coupling;
  /// Of nodes in one of the two images (the lower triangle), and of one in the first (columns) and one in the second.
  MatrixXd grid, across;
  VectorXd grid_gradient;
  double squares = 0;       ///< of bounded residuals, in standard deviations
  int points = 0, met = 0;  ///< paired; of those that fall on a reading

  bool is_good() const { return points >= kMinPoints && points >= kMinOverlap * met; }
};

/// Those of all poses (right increments, six each) and after them the nodes; of the matrix, the lower triangle.
struct System {
  System(std::size_t poses, std::size_t nodes)
      : grid(static_cast<Index>(6 * poses)),
        h(MatrixXd::Zero(grid + static_cast<Index>(nodes), grid + static_cast<Index>(nodes))),
        b(VectorXd::Zero(h.rows())) {}
  Index grid;  ///< where the nodes begin
  MatrixXd h;
  VectorXd b;

  Index nodes() const { return h.rows() - grid; }
  /// Of the motion T between two poses, of which the second is the later: exp(ξ) T with ξ = Ad_T a − b.
  void add_motion(const Pair& pair, const Matrix6d& adjoint, const Matrix6d& motion, const Vector6d& gradient) {
    const auto first = static_cast<Index>(6 * pair.first), second = static_cast<Index>(6 * pair.second);
    h.block<6, 6>(first, first) += adjoint.transpose() * motion * adjoint;
    h.block<6, 6>(second, first) -= motion * adjoint;
    h.block<6, 6>(second, second) += motion;
    b.segment<6>(first) += adjoint.transpose() * gradient;
    b.segment<6>(second) -= gradient;
  }
  void add(const Pair& pair, const Matrix6d& adjoint, const Equations& e) {
    add_motion(pair, adjoint, e.motion, e.motion_gradient);
    if (nodes() == 0) return;
    h.block(grid, static_cast<Index>(6 * pair.first), nodes(), 6) += e.coupling.transpose() * adjoint;
    h.block(grid, static_cast<Index>(6 * pair.second), nodes(), 6) -= e.coupling.transpose();
    h.bottomRightCorner(nodes(), nodes()) += e.grid + e.across + e.across.transpose();
    b.tail(nodes()) += e.grid_gradient;
  }
};

/// Adds the shares of nodes to a column of a matrix, from the row of four with that number on.
void add_column(double factor, const DepthDistortion::Nodes& nodes, std::size_t first_row, Index column,
                MatrixXd* matrix) {
  for (std::size_t row = first_row; row < 4; ++row)
    matrix->col(column).segment<4>(static_cast<Index>(nodes.row(row))) +=
        factor * Eigen::Vector4d::Map(&nodes.share[4 * row]);
}

/// What one point says: its residual, and how that changes.
struct PointResidual {
  double value;
  Vector6d by_motion;
  double by_first, by_second;  ///< with the distortion at either pixel
};

class Estimator {
 public:
  Estimator(const std::vector<DepthCalibration::View>& views, const Pinhole& camera, int level, double stray,
            int threads)
      : views_(views),
        camera_(camera.level(level)),
        scale_(1 << level),
        stray_(stray),
        threads_(threads),
        distortion_(camera.width, camera.height) {
    tabulate_nodes();
    tabulate_distortion();
  }

  std::optional<DepthCalibrationResult> run(const Trajectory& path) {
    find_poses(path);
    choose_pairs();
    DepthCalibrationResult result;
    for (int round = 0; round < kRounds; ++round) {
      const bool joint = round >= kPoseRounds;
      if (round == kPoseRounds) result.before = rms_of_judges();
      result.pairs = iterate(round < kPoseRounds / 2 ? kWideGate : kGate, joint);
      if (result.pairs < kMinPairs) return std::nullopt;
      if (joint && step_ < kConvergedStep) break;
    }
    result.after = rms_of_judges();
    result.distortion = distortion_;
    result.path = corrected(path);
    return result;
  }

 private:
  /// A pixel of a view: its point with the distortion taken out, and the normal; nothing where there is no reading.
  struct Point {
    Vector3d ray, normal;
    double z;
    Vector3d position() const { return z * ray; }
  };
  std::optional<Point> point(const DepthCalibration::View& view, int x, int y) const;
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(camera_.width) + static_cast<std::size_t>(x);
  }
  void tabulate_nodes();
  /// After each step.
  void tabulate_distortion();

  void find_poses(const Trajectory& path);
  void choose_pairs();
  void pair_on_the_way(std::size_t first);
  void pair_with_revisits(std::size_t first);
  void keep_apart_judges();
  /// What the scene moves by from one pose to another.
  double change(std::size_t first, std::size_t second) const { return view_change(given_motion({first, second})); }
  /// second_from_first, as given and as it is now.
  SE3 given_motion(const Pair& pair) const { return poses_[pair.second].given.inverse() * poses_[pair.first].given; }
  SE3 motion(const Pair& pair) const {
    return poses_[pair.second].world_from_camera.inverse() * poses_[pair.first].world_from_camera;
  }
  double seconds(std::size_t first, std::size_t second) const {
    return to_seconds(poses_[second].view->time - poses_[first].view->time);
  }
  bool in_one_piece(std::size_t first, std::size_t second) const {
    return poses_[first].view->piece == poses_[second].view->piece;
  }

  std::size_t iterate(double gate, bool joint);
  /// 1/m, of the pairs that nothing was estimated from.
  double rms_of_judges() const;
  Equations equations(const Pair& pair, double gate, bool joint) const;
  void add_point(const Pair& pair, const SE3& second_from_first, int x, int y, double gate, bool joint,
                 Equations* out) const;
  static void add(const PointResidual& residual, const DepthDistortion::Nodes* first,
                  const DepthDistortion::Nodes* second, Equations* out);
  static void add_nodes(const PointResidual& residual, double weight, double slope, const DepthDistortion::Nodes& nodes,
                        Equations* out);
  /// That the path is roughly right, and what is known of the distortion beforehand.
  void hold_path(System* system) const;
  void hold_nodes(System* system) const;
  void take_step(const System& system);
  /// The given path, moved with the poses: from one to the next by ever more of what the next one moved.
  Trajectory corrected(const Trajectory& path) const;

  const std::vector<DepthCalibration::View>& views_;
  Pinhole camera_;  ///< of the views
  int scale_;       ///< pixels of the image along one of a view
  double stray_;
  ThreadPool threads_;
  DepthDistortion distortion_;
  std::vector<DepthDistortion::Nodes> nodes_;  ///< of each pixel of a view
  std::vector<double> distortion_at_;          ///< the distortion there, 1/m
  std::vector<Pose> poses_;
  std::vector<Pair> pairs_, judges_;
  double pair_weight_ = 1;  ///< so that those estimated from weigh as all would
  double step_ = 0;         ///< 1/m, of the latest iteration
};

void Estimator::tabulate_nodes() {
  for (int y = 0; y < camera_.height; ++y)
    for (int x = 0; x < camera_.width; ++x)
      nodes_.push_back(distortion_.nodes((x + 0.5) * scale_ - 0.5, (y + 0.5) * scale_ - 0.5));
}

void Estimator::tabulate_distortion() {
  distortion_at_.clear();
  for (const DepthDistortion::Nodes& nodes : nodes_) distortion_at_.push_back(distortion_.at(nodes));
}

void Estimator::find_poses(const Trajectory& path) {
  auto pose = path.begin();
  for (const DepthCalibration::View& view : views_) {
    while (pose != path.end() && pose->time < view.time) ++pose;
    if (pose != path.end() && pose->time == view.time)
      poses_.push_back({&view, pose->world_from_camera, pose->world_from_camera});
  }
}

void Estimator::choose_pairs() {
  for (std::size_t first = 0; first < poses_.size(); ++first) {
    pair_on_the_way(first);
    pair_with_revisits(first);
  }
  keep_apart_judges();
}

/// `max_count` of the pairs at most, evenly spread.
std::vector<Pair> thinned(const std::vector<Pair>& pairs, std::size_t max_count) {
  if (pairs.size() <= max_count) return pairs;
  std::vector<Pair> result;
  for (std::size_t i = 0; i < max_count; ++i) result.push_back(pairs[(2 * i + 1) * pairs.size() / (2 * max_count)]);
  return result;
}

void Estimator::keep_apart_judges() {
  const auto all = static_cast<double>(pairs_.size());
  std::vector<Pair> others;
  for (std::size_t i = 0; i < pairs_.size(); ++i)
    (i % kJudgeStep == kJudgeStep - 1 ? judges_ : others).push_back(pairs_[i]);
  pairs_ = thinned(others, kMaxPairs);
  pair_weight_ = pairs_.empty() ? 1 : all / static_cast<double>(pairs_.size());
  judges_ = thinned(judges_, kMaxJudges);
}

void Estimator::pair_on_the_way(std::size_t first) {
  std::size_t second = first + 1;
  for (const double away : kAway) {
    while (second < poses_.size() && change(first, second) < away) ++second;
    if (second == poses_.size() || !in_one_piece(first, second) || seconds(first, second) > kMaxSeconds) return;
    pairs_.push_back({first, second});
  }
}

void Estimator::pair_with_revisits(std::size_t first) {
  std::vector<std::size_t> again;
  for (std::size_t second = first + 1; second < poses_.size() && in_one_piece(first, second); ++second) {
    if (seconds(first, second) <= kMaxSeconds) continue;
    if (const double away = change(first, second); away > 0.8 * kAway.front() && away < kAway.back())
      again.push_back(second);
  }
  const std::size_t number = std::min(kRevisits, again.size());
  for (std::size_t i = 0; i < number; ++i) pairs_.push_back({first, again[(2 * i + 1) * again.size() / (2 * number)]});
}

std::optional<Estimator::Point> Estimator::point(const DepthCalibration::View& view, int x, int y) const {
  const double z = view.depth.at(x, y);
  const Vector3d normal(view.normal_x.at(x, y), view.normal_y.at(x, y), view.normal_z.at(x, y));
  if (!(z > 0) || normal.squaredNorm() < 0.5) return std::nullopt;
  const double inverse = 1 / z - distortion_at_[index(x, y)];
  if (inverse < 0.05) return std::nullopt;
  const Vector3d ray((x - double{camera_.cx}) / camera_.fx, (y - double{camera_.cy}) / camera_.fy, 1);
  return Point{ray, normal, 1 / inverse};
}

void Estimator::add_point(const Pair& pair, const SE3& second_from_first, int x, int y, double gate, bool joint,
                          Equations* out) const {
  const std::optional<Point> first = point(*poses_[pair.first].view, x, y);
  if (!first) return;
  const Eigen::Matrix3d& rotation = second_from_first.rotation();
  const Vector3d moved = second_from_first * first->position();
  if (moved.z() < 0.2) return;
  const auto u = static_cast<int>(std::lround(moved.x() / moved.z() * camera_.fx + camera_.cx));
  const auto v = static_cast<int>(std::lround(moved.y() / moved.z() * camera_.fy + camera_.cy));
  if (u < 0 || v < 0 || u >= camera_.width || v >= camera_.height) return;
  const std::optional<Point> second = point(*poses_[pair.second].view, u, v);
  if (!second) return;
  ++out->met;
  const double area = first->z * second->z;
  const Vector3d apart = moved - second->position();
  if (second->normal.dot(rotation * first->normal) < kCosNormals || apart.norm() > gate * area) return;
  PointResidual r;
  r.value = second->normal.dot(apart) / area;
  r.by_motion << moved.cross(second->normal), second->normal;
  r.by_motion /= area;
  // z = 1/(w − d): dz = z² dd. The second terms are those of the division.
  r.by_first = second->normal.dot(rotation * first->ray) * first->z / second->z - r.value * first->z;
  r.by_second = -second->normal.dot(second->ray) * second->z / first->z - r.value * second->z;
  if (!joint) return add(r, nullptr, nullptr, out);
  add(r, &nodes_[index(x, y)], &nodes_[index(u, v)], out);
}

void Estimator::add(const PointResidual& r, const DepthDistortion::Nodes* first, const DepthDistortion::Nodes* second,
                    Equations* out) {
  const double size = std::abs(r.value) / kSigma, weight = (size < kHuber ? 1 : kHuber / size) / (kSigma * kSigma);
  ++out->points;
  out->squares += std::min(size, kHuber) * std::min(size, kHuber);
  out->motion += weight * r.by_motion * r.by_motion.transpose();
  out->motion_gradient -= weight * r.value * r.by_motion;
  if (first == nullptr) return;
  add_nodes(r, weight, r.by_first, *first, out);
  add_nodes(r, weight, r.by_second, *second, out);
  for (std::size_t i = 0; i < 16; ++i)
    add_column(weight * r.by_first * first->share[i] * r.by_second, *second, 0, static_cast<Index>(first->index(i)),
               &out->across);
}

/// Of the sixteen nodes in one image.
void Estimator::add_nodes(const PointResidual& r, double weight, double slope, const DepthDistortion::Nodes& nodes,
                          Equations* out) {
  for (std::size_t i = 0; i < 16; ++i) {
    const double weighted = weight * slope * nodes.share[i];
    const auto node = static_cast<Index>(nodes.index(i));
    out->grid_gradient[node] -= weighted * r.value;
    out->coupling.col(node) += weighted * r.by_motion;
    add_column(weighted * slope, nodes, i / 4, node, &out->grid);
  }
}

Equations Estimator::equations(const Pair& pair, double gate, bool joint) const {
  Equations out(joint ? static_cast<Index>(distortion_.values().size()) : 0);
  const SE3 second_from_first = motion(pair);
  const auto first_x = static_cast<int>(pair.first % kPixelStep), first_y = static_cast<int>(pair.second % kPixelStep);
  for (int y = first_y; y < camera_.height; y += kPixelStep)
    for (int x = first_x; x < camera_.width; x += kPixelStep)
      add_point(pair, second_from_first, x, y, gate, joint, &out);
  return out;
}

/// One Gauss-Newton step; how many pairs were used.
std::size_t Estimator::iterate(double gate, bool joint) {
  System system(poses_.size(), joint ? distortion_.values().size() : 0);
  std::size_t used = 0;
  std::vector<Equations> batch(kBatch, Equations(0));
  for (std::size_t begin = 0; begin < pairs_.size(); begin += kBatch) {
    const std::size_t count = std::min(kBatch, pairs_.size() - begin);
    threads_.run(static_cast<int>(count), [&](int i, int) {
      batch[static_cast<std::size_t>(i)] = equations(pairs_[begin + static_cast<std::size_t>(i)], gate, joint);
    });
    for (std::size_t i = 0; i < count; ++i) {  // in order: the same sums with any number of threads
      const Equations& e = batch[i];
      if (!e.is_good()) continue;
      system.add(pairs_[begin + i], motion(pairs_[begin + i]).adjoint(), e);
      ++used;
    }
  }
  system.h *= pair_weight_ / kRedundancy;
  system.b *= pair_weight_ / kRedundancy;
  hold_path(&system);
  if (joint) hold_nodes(&system);
  take_step(system);
  return used;
}

double Estimator::rms_of_judges() const {
  std::vector<Equations> all(judges_.size(), Equations(0));
  threads_.run(static_cast<int>(all.size()), [&](int i, int) {
    all[static_cast<std::size_t>(i)] = equations(judges_[static_cast<std::size_t>(i)], kGate, false);
  });
  double squares = 0, points = 0;
  for (const Equations& e : all) {
    if (!e.is_good()) continue;
    squares += e.squares;
    points += e.points;
  }
  return points > 0 ? kSigma * std::sqrt(squares / points) : 0;
}

void Estimator::hold_path(System* system) const {
  system->h.diagonal().head(system->grid).array() += 1 / (kLoose * kLoose);
  for (std::size_t i = 1; i < poses_.size(); ++i) {
    if (!in_one_piece(i - 1, i)) continue;
    const Pair step{i - 1, i};
    const SE3 now = motion(step);
    const Vector6d off = (now * given_motion(step).inverse()).log();
    Vector6d sigma;
    sigma << Vector3d::Constant(stray_), Vector3d::Constant(stray_ * kSceneDepth);
    const Vector6d weight = sigma.cwiseAbs2().cwiseInverse() / seconds(i - 1, i);
    system->add_motion(step, now.adjoint(), weight.asDiagonal(), -weight.cwiseProduct(off));
  }
}

void Estimator::hold_nodes(System* system) const {
  constexpr Index kColumns = DepthDistortion::kColumns;
  const Index nodes = system->nodes();
  auto h = system->h.bottomRightCorner(nodes, nodes);
  auto b = system->b.tail(nodes);
  const Eigen::Map<const VectorXd> values(distortion_.values().data(), nodes);
  h.diagonal().array() += 1 / (kNodeSigma * kNodeSigma);
  b -= values / (kNodeSigma * kNodeSigma);
  const auto hold_second_difference = [&](Index middle, Index step) {
    const std::array<Index, 3> index = {middle - step, middle, middle + step};
    constexpr std::array<double, 3> kShare = {1, -2, 1};
    const double value = values[index[0]] - 2 * values[index[1]] + values[index[2]];
    for (std::size_t i = 0; i < 3; ++i) {
      b[index[i]] -= kShare[i] * value / (kCurvatureSigma * kCurvatureSigma);
      for (std::size_t j = 0; j < 3; ++j)
        h(index[i], index[j]) += kShare[i] * kShare[j] / (kCurvatureSigma * kCurvatureSigma);
    }
  };
  for (Index row = 0; row < distortion_.rows(); ++row)
    for (Index column = 0; column < kColumns; ++column) {
      const Index node = row * kColumns + column;
      if (column > 0 && column + 1 < kColumns) hold_second_difference(node, 1);
      if (row > 0 && row + 1 < distortion_.rows()) hold_second_difference(node, kColumns);
    }
}

void Estimator::take_step(const System& system) {
  const VectorXd step = system.h.llt().solve(system.b);
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    SE3& pose = poses_[i].world_from_camera;
    pose = (pose * SE3::exp(step.segment<6>(static_cast<Index>(6 * i)))).normalized();
  }
  const Index nodes = system.nodes();
  if (nodes == 0) return;
  step_ = std::sqrt(step.tail(nodes).squaredNorm() / static_cast<double>(nodes));
  VectorXd::Map(distortion_.values().data(), nodes) += step.tail(nodes);
  tabulate_distortion();
}

Trajectory Estimator::corrected(const Trajectory& path) const {
  const auto moved = [&](std::size_t i) { return poses_[i].world_from_camera * poses_[i].given.inverse(); };
  Trajectory out;
  std::size_t next = 0;  // the first pose that is no earlier
  for (const StampedPose& pose : path) {
    while (next + 1 < poses_.size() && poses_[next].view->time < pose.time) ++next;
    SE3 by = moved(next);
    if (next > 0 && pose.time < poses_[next].view->time && in_one_piece(next - 1, next)) {
      const SE3 previous = moved(next - 1);
      const double share = to_seconds(pose.time - poses_[next - 1].view->time) / seconds(next - 1, next);
      by = SE3::exp(share * (by * previous.inverse()).log()) * previous;
    }
    out.push_back({pose.time, (by * pose.world_from_camera).normalized()});
  }
  return out;
}

int view_level(const Pinhole& camera) {
  int level = 0;
  while (camera.level(level).width > kMaxWidth) ++level;
  return level;
}

}  // namespace

double view_change(const SE3& motion) {
  return so3::angle(motion.rotation()) + motion.translation().norm() / kSceneDepth;
}

DepthCalibration::DepthCalibration(const Pinhole& camera, const PreprocessParameters& parameters,
                                   const Backend& backend, int frames)
    : camera_(camera),
      backend_(&backend),
      level_(view_level(camera)),
      stride_((frames + kMaxViews - 1) / kMaxViews),
      live_(camera, parameters, level_ + 1, backend, false, level_) {}

void DepthCalibration::add(const Frame& frame) {
  if (seen_++ % std::max(stride_, 1) != 0) return;
  live_.prepare(frame);
  const DepthLevel& level = live_.pyramid()[static_cast<std::size_t>(level_)];
  views_.push_back({frame.time, piece_, download(*backend_, level.depth), download(*backend_, level.normal_x),
                    download(*backend_, level.normal_y), download(*backend_, level.normal_z)});
}

std::optional<DepthCalibrationResult> DepthCalibration::estimate(const Trajectory& path, Tracked on,
                                                                 int threads) const {
  return Estimator(views_, camera_, level_, on == Tracked::as_measured ? kStrayAsMeasured : kStrayUndistorted, threads)
      .run(path);
}

}  // namespace plumbline
