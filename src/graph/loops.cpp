#include "graph/loops.h"

#include <algorithm>
#include <cmath>

#include "core/median.h"
#include "graph/consistent_set.h"
#include "place/keyframes.h"
#include "plumbline/angles.h"

namespace plumbline {
namespace {

// In radians, 1.5 m as one, as pose_distance has them.
constexpr double kElsewhere = 3;  // of path between two views that are no neighbours
constexpr double kNear = 0.6;     // between views that show the same, and from which registration converges
constexpr double kDriftPerWay = 0.02, kMaxNear = 1.2;
constexpr double kApart = 1;                      // of path between two candidates of one view
constexpr std::size_t kNearest = 2, kLikest = 1;  // candidates of a view

// What a loop that is accepted must know, standard deviations: a third of what is called wrong (5 cm, 2.5°).
constexpr double kMaxSigmaTranslation = 0.05 / 3, kMaxSigmaRotation = radians(2.5) / 3;
constexpr double kMinOverlap = 0.1, kMaxViolation = 0.02, kMinAgreement = 0.7;
constexpr double kMaxOneWay = 1.5;  // χ² over 6: both ways are of the same pixels and agree better than two views would
// χ² over 6 that 99.9 % of the right ones stay below; and where the path's own covariance enters, which is less sure.
constexpr double kMaxChi2 = 3.75, kMaxPathChi2 = 9;

double sigma_of(const Matrix6d& covariance, int at) {
  return std::sqrt(covariance.diagonal().segment<3>(at).maxCoeff());
}

/// Candidates of one view, nearest first, none near another along the path.
class Choice {
 public:
  Choice(const std::vector<PathView>& views, std::size_t second) : views_(views), second_(second) {
    for (std::size_t first = 0; first < second; ++first)
      if (const double away = distance(first); away < reach(first)) nearby_.push_back({first, away});
  }

  std::vector<std::size_t> choose() {
    take(kNearest, [&](const Candidate& c) { return c.away; });
    take(kLikest, [&](const Candidate& c) { return dissimilarity(views_[c.view].code, views_[second_].code); });
    return chosen_;
  }

 private:
  struct Candidate {
    std::size_t view;
    double away;
  };

  double distance(std::size_t first) const {
    return pose_distance(views_[first].world_from_camera, views_[second_].world_from_camera);
  }
  double travelled(std::size_t first, std::size_t second) const {
    return std::abs(views_[second].travelled - views_[first].travelled);
  }
  double reach(std::size_t first) const {
    const double way = travelled(first, second_);
    return way < kElsewhere ? 0 : std::min(kMaxNear, kNear + kDriftPerWay * way);
  }

  template <class Cost>
  void take(std::size_t count, const Cost& cost) {
    std::vector<std::pair<double, std::size_t>> order;
    for (const Candidate& c : nearby_) order.emplace_back(cost(c), c.view);
    std::sort(order.begin(), order.end());
    for (const auto& [unused, view] : order) {
      if (count == 0) return;
      const bool is_new = std::none_of(chosen_.begin(), chosen_.end(),
                                       [&, at = view](std::size_t other) { return travelled(other, at) < kApart; });
      if (!is_new) continue;
      chosen_.push_back(view);
      --count;
    }
  }

  const std::vector<PathView>& views_;
  std::size_t second_;
  std::vector<Candidate> nearby_;
  std::vector<std::size_t> chosen_;
};

bool is_same(const LoopPair& a, const LoopPair& b) { return a.first == b.first && a.second == b.second; }

/// Whether one loop is what the other one says, carried along the path.
bool agree(const ViewEdge& a, const ViewEdge& b, const Odometry& odometry, double scale) {
  const RelativePose other{b.motion.first_from_second, scale * b.motion.covariance};
  const RelativePose carried =
      compose(compose(odometry.between(a.first, b.first), other), odometry.between(b.second, a.second));
  return normalised_difference(a.motion.first_from_second, carried.first_from_second,
                               carried.covariance + scale * a.motion.covariance) < kMaxChi2;
}

void test_against_each_other(const Odometry& odometry, double scale, std::vector<TriedLoop>* loops) {
  std::vector<TriedLoop*> good;
  for (TriedLoop& loop : *loops)
    if (loop.status == LoopStatus::accepted) good.push_back(&loop);
  const std::vector<std::size_t> set = consistent_set(good.size(), [&](std::size_t a, std::size_t b) {
    return agree(*good[a]->edge, *good[b]->edge, odometry, scale);
  });
  for (std::size_t i = 0; i < good.size(); ++i)
    if (!std::binary_search(set.begin(), set.end(), i)) good[i]->status = LoopStatus::contradicted;
}

}  // namespace

double covariance_scale(const std::vector<PathView>& views, const std::vector<std::optional<ViewEdge>>& neighbours) {
  std::vector<double> differences;
  for (const std::optional<ViewEdge>& edge : neighbours) {
    if (!edge) continue;
    const SE3 tracked = views[edge->first].world_from_camera.inverse() * views[edge->second].world_from_camera;
    differences.push_back(normalised_difference(edge->motion.first_from_second, tracked, edge->motion.covariance));
  }
  constexpr double kMin = 0.1, kMax = 4;
  return std::clamp(median(std::move(differences)) / kMedianChi2, kMin, kMax);
}

LoopStatus judge_alone(const ViewEdge& edge, double scale) {
  const Matrix6d covariance = scale * edge.motion.covariance;
  if (edge.overlap() < kMinOverlap || sigma_of(covariance, 0) > kMaxSigmaRotation ||
      sigma_of(covariance, 3) > kMaxSigmaTranslation)
    return LoopStatus::too_weak;
  if (edge.inconsistency > kMaxOneWay * scale) return LoopStatus::one_way;
  if (edge.violation() > kMaxViolation || edge.agreement() < kMinAgreement) return LoopStatus::seen_through;
  return LoopStatus::accepted;
}

LoopStatus judge(const ViewEdge& edge, const Odometry& odometry, double scale) {
  const LoopStatus alone = judge_alone(edge, scale);
  if (alone != LoopStatus::accepted) return alone;
  const RelativePose path = odometry.between(edge.first, edge.second);
  const double difference = normalised_difference(edge.motion.first_from_second, path.first_from_second,
                                                  path.covariance + scale * edge.motion.covariance);
  return difference < kMaxPathChi2 ? LoopStatus::accepted : LoopStatus::too_far;
}

std::vector<LoopPair> loop_candidates(const std::vector<PathView>& views) {
  std::vector<LoopPair> pairs;
  for (std::size_t second = 0; second < views.size(); ++second)
    for (const std::size_t first : Choice(views, second).choose()) pairs.push_back({first, second});
  return pairs;
}

void find_loops(const std::vector<PathView>& views, const Odometry& odometry, double scale, ViewMatcher* matcher,
                const std::function<bool()>& stopping, std::vector<TriedLoop>* loops) {
  std::erase_if(*loops, [](const TriedLoop& loop) { return loop.status != LoopStatus::accepted; });
  const std::size_t known = loops->size();
  for (const LoopPair& pair : loop_candidates(views)) {
    if (stopping && stopping()) return loops->clear();
    const auto end = loops->begin() + static_cast<std::ptrdiff_t>(known);
    if (std::any_of(loops->begin(), end, [&](const TriedLoop& loop) { return is_same(loop.pair, pair); })) continue;
    TriedLoop loop{pair, LoopStatus::not_registered, matcher->match(views, pair.first, pair.second, Reach::far)};
    if (loop.edge) loop.status = judge(*loop.edge, odometry, scale);
    loops->push_back(std::move(loop));
  }
  test_against_each_other(odometry, scale, loops);
}

}  // namespace plumbline
