#include "tracking/depth_calibration.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace plumbline {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kDegree = std::numbers::pi / 180;
constexpr int kMostViews = 200, kWidest = 200;  // the latter in pixels

// From each frame to the first that is so far away: near ones for the slopes of the pattern, farther ones for its
// broad shape. A metre and a half turns a translation into the angle by which the scene moves in the image.
constexpr double kNear = 10 * kDegree, kFar = 25 * kDegree, kSceneDepth = 1.5, kLongest = 2;  // radians, m, s
constexpr std::size_t kFewestPairs = 20;

// Residuals and gates in 1/m. A Kinect's noise is 0.002/m at any depth (Nguyen et al. 2012).
constexpr double kSigma = 0.003, kHuber = 2, kWideGate = 0.06, kGate = 0.03, kCosNormals = 0.87;
constexpr double kRedundancy = 100;  // points that tell no more than one: neighbours, and one thing in many pairs
constexpr int kFewestPoints = 300;
constexpr double kLeastOverlap = 0.3;
constexpr int kPoseRounds = 4, kRounds = 14;
constexpr double kSettled = 1e-4;  // 1/m: a smaller step of the nodes is the last

// What is known beforehand: 1/m, of a node, and of its second difference. Herrera et al. show patterns of some tenths
// of a pixel (a pixel is 0.023/m with a Kinect) and one or two bumps across the image.
constexpr double kNodeSigma = 0.02, kBendSigma = 0.008;

struct Pair {
  std::size_t first, second;  ///< of the views
  SE3 second_from_first;
};

/// Normal equations of one pair: of its motion (left increments), of the nodes, and of both together.
struct Equations {
  explicit Equations(Eigen::Index nodes)
      : coupling(MatrixXd::Zero(6, nodes)), grid(MatrixXd::Zero(nodes, nodes)), grid_gradient(VectorXd::Zero(nodes)) {}
  Matrix6d motion = Matrix6d::Zero();
  Vector6d motion_gradient = Vector6d::Zero();
  MatrixXd coupling, grid;
  VectorXd grid_gradient;
  double squares = 0;       ///< of bounded residuals, in standard deviations
  int points = 0, met = 0;  ///< paired; of those that fall on a reading

  bool is_good() const { return points >= kFewestPoints && points >= kLeastOverlap * met; }
};

/// What one point says: its residual, and how that changes.
struct PointResidual {
  double value;
  Vector6d by_motion;
  double by_first, by_second;  ///< with the distortion at either pixel
};

class Estimator {
 public:
  Estimator(const std::vector<DepthCalibration::View>& views, const Pinhole& camera, int level)
      : views_(views), camera_(camera.level(level)), scale_(1 << level), distortion_(camera.width, camera.height) {
    tabulate_nodes();
    tabulate_distortion();
  }

  void choose_pairs(const Trajectory& path);

  std::optional<DepthCalibrationResult> run() {
    DepthCalibrationResult result;
    for (int round = 0; round < kRounds; ++round) {
      const bool joint = round >= kPoseRounds;
      result.pairs = iterate(round < kPoseRounds / 2 ? kWideGate : kGate, joint);
      if (result.pairs < kFewestPairs) return std::nullopt;
      (joint ? result.after : result.before) = rms_;
      if (joint && step_ < kSettled) break;
    }
    result.distortion = distortion_;
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

  std::size_t iterate(double gate, bool joint);
  Equations equations(const Pair& pair, double gate, bool joint) const;
  void add_point(const Pair& pair, int x, int y, double gate, bool joint, Equations* out) const;
  void add(const PointResidual& residual, const DepthDistortion::Nodes* first, const DepthDistortion::Nodes* second,
           Equations* out) const;
  void add_priors(MatrixXd* h, VectorXd* b) const;

  const std::vector<DepthCalibration::View>& views_;
  Pinhole camera_;  ///< of the views
  int scale_;       ///< pixels of the image along one of a view
  DepthDistortion distortion_;
  std::vector<DepthDistortion::Nodes> nodes_;  ///< of each pixel of a view
  std::vector<double> bend_;                   ///< the distortion there, 1/m
  std::vector<Pair> pairs_;
  double rms_ = 0, step_ = 0;  // 1/m, of the last iteration
};

void Estimator::tabulate_nodes() {
  for (int y = 0; y < camera_.height; ++y)
    for (int x = 0; x < camera_.width; ++x)
      nodes_.push_back(distortion_.nodes((x + 0.5) * scale_ - 0.5, (y + 0.5) * scale_ - 0.5));
}

void Estimator::tabulate_distortion() {
  bend_.clear();
  for (const DepthDistortion::Nodes& nodes : nodes_) bend_.push_back(distortion_.at(nodes));
}

void Estimator::choose_pairs(const Trajectory& path) {
  std::vector<std::pair<std::size_t, SE3>> known;  // views and where they were taken
  auto pose = path.begin();
  for (std::size_t i = 0; i < views_.size(); ++i) {
    while (pose != path.end() && pose->time < views_[i].time) ++pose;
    if (pose != path.end() && pose->time == views_[i].time) known.emplace_back(i, pose->world_from_camera);
  }
  for (std::size_t i = 0; i < known.size(); ++i) {
    std::size_t j = i + 1;
    for (const double far : {kNear, kFar}) {
      const auto motion = [&] { return known[j].second.inverse() * known[i].second; };
      while (j < known.size() && view_change(motion()) < far) ++j;
      if (j == known.size()) break;
      const DepthCalibration::View &first = views_[known[i].first], &second = views_[known[j].first];
      if (first.piece != second.piece || to_seconds(second.time - first.time) > kLongest) break;
      pairs_.push_back({known[i].first, known[j].first, motion()});
    }
  }
}

std::optional<Estimator::Point> Estimator::point(const DepthCalibration::View& view, int x, int y) const {
  const double z = view.depth.at(x, y);
  const Vector3d normal(view.normal_x.at(x, y), view.normal_y.at(x, y), view.normal_z.at(x, y));
  if (!(z > 0) || normal.squaredNorm() < 0.5) return std::nullopt;
  const double inverse = 1 / z - bend_[index(x, y)];
  if (inverse < 0.05) return std::nullopt;
  const Vector3d ray((x - double{camera_.cx}) / camera_.fx, (y - double{camera_.cy}) / camera_.fy, 1);
  return Point{ray, normal, 1 / inverse};
}

void Estimator::add_point(const Pair& pair, int x, int y, double gate, bool joint, Equations* out) const {
  const std::optional<Point> first = point(views_[pair.first], x, y);
  if (!first) return;
  const Eigen::Matrix3d& rotation = pair.second_from_first.rotation();
  const Vector3d moved = pair.second_from_first * first->position();
  if (moved.z() < 0.2) return;
  const auto u = static_cast<int>(std::lround(moved.x() / moved.z() * camera_.fx + camera_.cx));
  const auto v = static_cast<int>(std::lround(moved.y() / moved.z() * camera_.fy + camera_.cy));
  if (u < 0 || v < 0 || u >= camera_.width || v >= camera_.height) return;
  const std::optional<Point> second = point(views_[pair.second], u, v);
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
                    Equations* out) const {
  const double size = std::abs(r.value) / kSigma, weight = (size < kHuber ? 1 : kHuber / size) / (kSigma * kSigma);
  ++out->points;
  out->squares += std::min(size, kHuber) * std::min(size, kHuber);
  out->motion += weight * r.by_motion * r.by_motion.transpose();
  out->motion_gradient -= weight * r.value * r.by_motion;
  if (first == nullptr) return;
  std::array<Eigen::Index, 8> index;
  std::array<double, 8> slope;
  for (std::size_t i = 0; i < 4; ++i) {
    index[i] = static_cast<Eigen::Index>(first->index[i]);
    slope[i] = r.by_first * first->share[i];
    index[4 + i] = static_cast<Eigen::Index>(second->index[i]);
    slope[4 + i] = r.by_second * second->share[i];
  }
  for (std::size_t i = 0; i < 8; ++i) {
    for (std::size_t j = 0; j < 8; ++j) out->grid(index[i], index[j]) += weight * slope[i] * slope[j];
    out->grid_gradient[index[i]] -= weight * slope[i] * r.value;
    out->coupling.col(index[i]) += weight * slope[i] * r.by_motion;
  }
}

Equations Estimator::equations(const Pair& pair, double gate, bool joint) const {
  Equations out(joint ? static_cast<Eigen::Index>(distortion_.values().size()) : 0);
  for (int y = 0; y < camera_.height; y += 2)
    for (int x = 0; x < camera_.width; x += 2) add_point(pair, x, y, gate, joint, &out);
  return out;
}

/// One Gauss-Newton step; how many pairs were used.
std::size_t Estimator::iterate(double gate, bool joint) {
  const auto size = static_cast<Eigen::Index>(distortion_.values().size());
  MatrixXd h = MatrixXd::Zero(size, size);
  VectorXd b = VectorXd::Zero(size);
  struct Used {
    Pair* pair;
    VectorXd still;     // the pair's step if the nodes stay
    MatrixXd by_nodes;  // what their step takes off it
  };
  std::vector<Used> used;
  double squares = 0, points = 0;
  for (Pair& pair : pairs_) {
    const Equations e = equations(pair, gate, joint);
    if (!e.is_good()) continue;
    const Eigen::LDLT<Matrix6d> motion(e.motion);
    used.push_back({&pair, motion.solve(e.motion_gradient), motion.solve(e.coupling)});
    squares += e.squares;
    points += e.points;
    if (!joint) continue;
    h += e.grid - e.coupling.transpose() * used.back().by_nodes;
    b += e.grid_gradient - e.coupling.transpose() * used.back().still;
  }
  VectorXd step = VectorXd::Zero(size);
  if (joint) {
    h /= kRedundancy;
    b /= kRedundancy;
    add_priors(&h, &b);
    step = h.ldlt().solve(b);
    step_ = std::sqrt(step.squaredNorm() / static_cast<double>(size));
    for (Eigen::Index i = 0; i < size; ++i) distortion_.values()[static_cast<std::size_t>(i)] += step[i];
    tabulate_distortion();
  }
  for (const Used& u : used) {
    const Vector6d move = joint ? Vector6d(u.still - u.by_nodes * step) : Vector6d(u.still);
    u.pair->second_from_first = (SE3::exp(move) * u.pair->second_from_first).normalized();
  }
  rms_ = points > 0 ? kSigma * std::sqrt(squares / points) : 0;
  return used.size();
}

void Estimator::add_priors(MatrixXd* h, VectorXd* b) const {
  constexpr Eigen::Index kColumns = DepthDistortion::kColumns;
  const Eigen::Map<const VectorXd> values(distortion_.values().data(),
                                          static_cast<Eigen::Index>(distortion_.values().size()));
  h->diagonal().array() += 1 / (kNodeSigma * kNodeSigma);
  *b -= values / (kNodeSigma * kNodeSigma);
  const auto bend = [&](Eigen::Index middle, Eigen::Index step) {
    const std::array<Eigen::Index, 3> index = {middle - step, middle, middle + step};
    constexpr std::array<double, 3> kShare = {1, -2, 1};
    const double value = values[index[0]] - 2 * values[index[1]] + values[index[2]];
    for (std::size_t i = 0; i < 3; ++i) {
      (*b)[index[i]] -= kShare[i] * value / (kBendSigma * kBendSigma);
      for (std::size_t j = 0; j < 3; ++j) (*h)(index[i], index[j]) += kShare[i] * kShare[j] / (kBendSigma * kBendSigma);
    }
  };
  for (Eigen::Index row = 0; row < distortion_.rows(); ++row)
    for (Eigen::Index column = 0; column < kColumns; ++column) {
      const Eigen::Index node = row * kColumns + column;
      if (column > 0 && column + 1 < kColumns) bend(node, 1);
      if (row > 0 && row + 1 < distortion_.rows()) bend(node, kColumns);
    }
}

int view_level(const Pinhole& camera) {
  int level = 0;
  while (camera.level(level).width > kWidest) ++level;
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
      stride_((frames + kMostViews - 1) / kMostViews),
      live_(camera, parameters, level_ + 1, backend, false, level_) {}

void DepthCalibration::add(const Frame& frame) {
  if (seen_++ % std::max(stride_, 1) != 0) return;
  live_.prepare(frame);
  const DepthLevel& level = live_.pyramid()[static_cast<std::size_t>(level_)];
  views_.push_back({frame.time, piece_, download(*backend_, level.depth), download(*backend_, level.normal_x),
                    download(*backend_, level.normal_y), download(*backend_, level.normal_z)});
}

std::optional<DepthCalibrationResult> DepthCalibration::estimate(const Trajectory& path) const {
  Estimator estimator(views_, camera_, level_);
  estimator.choose_pairs(path);
  return estimator.run();
}

}  // namespace plumbline
