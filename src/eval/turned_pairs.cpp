#include "eval/turned_pairs.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>

namespace plumbline::eval {
namespace {

constexpr Nanoseconds kSameStamp = 10'000;    // ns: stamps in files have at least six decimals, mostly
constexpr Nanoseconds kMaxGap = 100'000'000;  // ns, over which a hand's motion is taken to be even

/// Of one frame: the position and the unit quaternion, of which the sign is open.
struct View {
  std::size_t frame = 0;
  Eigen::Vector3d position;
  Eigen::Quaterniond rotation;
};

std::vector<View> known_views(const std::vector<std::optional<SE3>>& world_from_camera) {
  std::vector<View> views;
  for (std::size_t i = 0; i < world_from_camera.size(); ++i)
    if (const std::optional<SE3>& pose = world_from_camera[i]; pose && pose->is_finite())
      views.push_back({i, pose->translation(), pose->quaternion()});
  return views;
}

/// Which pairs are taken first.
class Preference {
 public:
  explicit Preference(double angle) : angle_(angle) {}
  bool operator()(const TurnedPair& a, const TurnedPair& b) const { return rank(a) < rank(b); }

 private:
  std::tuple<double, double, std::size_t, std::size_t> rank(const TurnedPair& pair) const {
    return {pair.translation, std::abs(pair.angle - angle_), pair.first, pair.second};
  }
  double angle_;
};

/// The pair of each frame that has one, ordered by first frames.
std::optional<TurnedPair> best_pair_of(std::size_t i, const std::vector<View>& views,
                                       const TurnedPairOptions& options) {
  const Preference preferred(options.angle);
  std::optional<TurnedPair> best;
  double reach = options.max_translation * options.max_translation;  // squared; nothing beyond it becomes the best
  for (std::size_t j = i + 1; j < views.size(); ++j) {
    const double squared = (views[j].position - views[i].position).squaredNorm();
    if (squared > reach) continue;
    const double angle = views[i].rotation.angularDistance(views[j].rotation);
    if (std::abs(angle - options.angle) > options.tolerance) continue;
    const TurnedPair pair{views[i].frame, views[j].frame, angle, std::sqrt(squared)};
    if (!best || preferred(pair, *best)) best = pair;
    reach = squared;
  }
  return best;
}

std::vector<TurnedPair> candidates(const std::vector<View>& views, const TurnedPairOptions& options) {
  std::vector<TurnedPair> pairs;
  for (std::size_t i = 0; i < views.size(); ++i)
    if (const auto best = best_pair_of(i, views, options)) pairs.push_back(*best);
  return pairs;
}

}  // namespace

std::optional<SE3> pose_at(const Trajectory& trajectory, Nanoseconds time) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), time,
                                      [](const StampedPose& pose, Nanoseconds t) { return pose.time < t; });
  if (after != trajectory.end() && after->time - time <= kSameStamp) return after->world_from_camera;
  if (after == trajectory.begin()) return std::nullopt;
  const StampedPose& before = *std::prev(after);
  if (time - before.time <= kSameStamp) return before.world_from_camera;
  if (after == trajectory.end() || after->time - before.time > kMaxGap) return std::nullopt;
  const double share = to_seconds(time - before.time) / to_seconds(after->time - before.time);
  const SE3 &a = before.world_from_camera, &b = after->world_from_camera;
  return SE3(a.quaternion().slerp(share, b.quaternion()),
             a.translation() + share * (b.translation() - a.translation()));
}

std::vector<TurnedPair> turned_pairs(const std::vector<std::optional<SE3>>& world_from_camera,
                                     const TurnedPairOptions& options) {
  const Preference preferred(options.angle);
  std::vector<std::vector<TurnedPair>> stretches(options.count);
  for (const TurnedPair& pair : candidates(known_views(world_from_camera), options))
    stretches[pair.first * options.count / world_from_camera.size()].push_back(pair);
  for (std::vector<TurnedPair>& stretch : stretches) std::sort(stretch.begin(), stretch.end(), preferred);

  std::vector<TurnedPair> chosen;
  for (std::size_t round = 0; chosen.size() < options.count; ++round) {
    std::vector<TurnedPair> offered;
    for (const std::vector<TurnedPair>& stretch : stretches)
      if (round < stretch.size()) offered.push_back(stretch[round]);
    if (offered.empty()) break;
    std::sort(offered.begin(), offered.end(), preferred);
    offered.resize(std::min(offered.size(), options.count - chosen.size()));
    chosen.insert(chosen.end(), offered.begin(), offered.end());
  }
  std::sort(chosen.begin(), chosen.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  return chosen;
}

}  // namespace plumbline::eval
