#include "place/relocaliser.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "plumbline/angles.h"
#include "tracking/live_frame.h"
#include "tracking/starts.h"

namespace plumbline {
namespace {

constexpr std::size_t kNearest = 20;           // keyframes that are tried
constexpr std::size_t kRefined = 4;            // candidates that are registered to the model
constexpr double kDistinct = 0.1;              // radians, as pose_distance has them: nearer poses are one place
constexpr double kMargin = 0.15;               // that the second-best place's agreement must be smaller by
constexpr double kClearMargin = 0.3;           // and for a place that is clear
constexpr double kElsewhere = 0.75;            // radians, as pose_distance has them: keyframes of another place
constexpr double kNear = 0.2;                  // radians, as pose_distance has them: from where it is expected
constexpr std::size_t kLookAlikes = 2;         // of these, that are registered to the model
constexpr double kRivalReach = 2;              // times the reach: nobody knows how fast a camera was carried
constexpr double kMaxAttitudeDifference = 65;  // degrees, between a keyframe's and the frame's
constexpr int kKeyframeLevels = 2;
constexpr double kMaxDrift = 0.03;  // of the way between two maps of one place: metres, or as pose_distance has it

/// Of the levels that iterate, the coarsest that a keyframe keeps.
int keyframe_levels(const TrackingParameters& tracking) {
  return std::min(kKeyframeLevels, static_cast<int>(tracking.iterations.size()));
}

/// Up in the camera's axes, by a reading.
Eigen::Vector3d up_in_camera(const Eigen::Matrix3d& earth_from_camera) { return earth_from_camera.row(2).transpose(); }

constexpr std::size_t kMaxCompared = 200;                    // keyframes
constexpr kernels::DepthTolerance kBehind = {0.04f, 0.02f};  // metres, and of the distance: a surface seen twice
constexpr kernels::DepthTolerance kOn = {0.015f, 0.01f};

ModelConsistency mean_over_views(ModelConsistency sums, std::vector<double> see_through, std::size_t compared) {
  const std::size_t seen = see_through.size();
  if (seen == 0) return {static_cast<int>(compared)};
  std::sort(see_through.begin(), see_through.end());
  const auto n = static_cast<double>(seen);
  sums.views = static_cast<int>(compared);
  sums.known /= static_cast<double>(compared);
  sums.matched /= n;
  sums.see_through = std::accumulate(see_through.begin(), see_through.end(), 0.0) / n;
  sums.worst_see_through = see_through[std::min(seen - 1, seen * 9 / 10)];
  return sums;
}

/// Whether the camera can have got there. The way may have drifted since.
bool is_reached(const Keyframe& keyframe, const PlaceQuery& query, double reach) {
  const double way = std::abs(keyframe.from.travelled - query.previous.travelled);
  const SE3 &there = keyframe.from.world_from_camera, &before = query.previous.world_from_camera;
  return (there.translation() - before.translation()).norm() <= reach + kMaxDrift * way;
}

FoundPlace* best_of(std::vector<FoundPlace>* places) {
  const auto best = std::max_element(places->begin(), places->end(), [](const FoundPlace& a, const FoundPlace& b) {
    return a.evidence.agreement() < b.evidence.agreement();
  });
  return best == places->end() ? nullptr : &*best;
}

/// A place that was mapped twice, a long way between, is no other place.
bool is_other_place(const FoundPlace& a, const FoundPlace& b) {
  const double way = std::abs(a.seed.travelled - b.seed.travelled),
               apart = pose_distance(a.evidence.result.world_from_camera, b.evidence.result.world_from_camera);
  return apart >= kDistinct && (are_consistent(a.seed.travelled, b.seed.travelled) || apart > kMaxDrift * way);
}

}  // namespace

double PlaceEvidence::agreement() const { return plumbline::agreement(result); }

/// Of what the images leave open about its position a singular registration says nothing.
double PlaceEvidence::uncertainty() const {
  const Eigen::Matrix3d position = result.pose_covariance.bottomRightCorner<3, 3>();
  const double square =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(position, Eigen::EigenvaluesOnly).eigenvalues()[2];
  return square > 0 ? std::sqrt(square) : std::numeric_limits<double>::infinity();
}

bool PlaceEvidence::meets(const PlaceLimits& limits) const {
  return agreement() >= limits.agreement && depth.see_through() < limits.see_through &&
         depth.matched() > limits.matched && depth.known() > limits.known && uncertainty() <= limits.uncertainty;
}

bool FoundPlace::is_clear() const {
  const bool is_distinctive = evidence.meets(kClear) && evidence.detail.support() >= kDetailClear;
  return (is_expected || is_distinctive) && rival <= evidence.agreement() - kClearMargin;
}

Relocaliser::Relocaliser(const Parameters& parameters, const Pinhole& camera, const Backend& backend,
                         RenderModel render, const OrientationSensor& sensor)
    : tracking_(without_limits(patient(parameters.tracking))),
      coarse_(far_reaching(parameters.tracking, keyframe_levels(parameters.tracking))),
      has_heading_(sensor.has_heading),
      backend_(&backend),
      render_(std::move(render)),
      keyframes_(keyframe_levels(parameters.tracking), backend),
      keyframe_levels_(make_pyramid(camera, keyframe_levels(parameters.tracking), backend,
                                    pyramid_levels(parameters.tracking) - keyframe_levels(parameters.tracking))),
      model_levels_(make_pyramid(camera, static_cast<int>(parameters.tracking.iterations.size()), backend,
                                 parameters.tracking.finest_level)) {}

PlaceEvidence Relocaliser::look(const DepthPyramid& live, const TrackingResult& result, double travelled) const {
  render_({result.world_from_camera, travelled}, &model_levels_);
  const DepthLevel& model = model_levels_.front();
  const DepthLevel& frame = live[live.size() - model_levels_.size()];
  return {result, backend_->reduce(kernels::CompareDepth{read_only(frame.depth), read_only(model.depth)})};
}

Relocaliser::Search Relocaliser::find(const PlaceQuery& query) const {
  Search search;
  std::vector<FoundPlace> places;
  for (const Viewpoint& start : distinct_starts(query, &search.starts)) places.push_back(refine(start, query));
  const FoundPlace* best = best_of(&places);
  if (best == nullptr) return search;
  FoundPlace place = *best;
  if (!is_recognised(&place, query)) return search;
  for (const FoundPlace& other : look_alikes(place, query, &search.starts)) places.push_back(other);
  for (const FoundPlace& other : places)
    if (is_other_place(other, place)) place.rival = std::max(place.rival, other.evidence.agreement());
  if (place.rival > place.evidence.agreement() - kMargin) return search;
  place.starts = search.starts;
  search.place = place;
  return search;
}

/// By itself, whatever else it may be.
bool Relocaliser::is_recognised(FoundPlace* place, const PlaceQuery& query) const {
  const SE3& found = place->evidence.result.world_from_camera;
  place->is_expected =
      query.is_near && std::any_of(query.expected.begin(), query.expected.end(), [&](const Viewpoint& expected) {
        return pose_distance(expected.world_from_camera, found) < kNear;
      });
  const PlaceEvidence& evidence = place->evidence;
  const bool is_met =
      place->is_expected ? evidence.meets(kExpected) : evidence.meets(kRecognised) || evidence.meets(kOpen);
  if (!is_met) return false;
  render_({found, place->seed.travelled}, &model_levels_);
  place->evidence.detail = compare_details(query.view.live, model_levels_);
  return place->is_expected || place->evidence.detail.support() >= kDetailRecognised;
}

DetailComparison Relocaliser::compare_details(const DepthPyramid& live, const DepthPyramid& model) const {
  return compare_detail(sample_surface(*backend_, live[live.size() - model.size()]),
                        sample_surface(*backend_, model.front()));
}

/// What else the frame may show, were it not for where it seems to be: the best of the keyframes elsewhere. The likest
/// of all may be views of that one place.
std::vector<FoundPlace> Relocaliser::look_alikes(const FoundPlace& place, const PlaceQuery& query, int* starts) const {
  const SE3& found = place.evidence.result.world_from_camera;
  const std::vector<Candidate> candidates = from_keyframes(
      query,
      [&](const Keyframe& keyframe) {
        return is_in_sight(keyframe, query) && is_reached(keyframe, query, kRivalReach * query.reach) &&
               pose_distance(keyframe.from.world_from_camera, found) >= kElsewhere;
      },
      starts);
  std::vector<FoundPlace> places;
  for (const Candidate& candidate : candidates) {
    if (places.size() == kLookAlikes) break;
    places.push_back(refine(candidate.from, query));
  }
  return places;
}

/// What is expected, and the best of what the keyframes say.
std::vector<Viewpoint> Relocaliser::distinct_starts(const PlaceQuery& query, int* starts) const {
  const std::vector<Candidate> candidates = from_keyframes(
      query,
      [&](const Keyframe& keyframe) {
        return is_in_sight(keyframe, query) && is_reached(keyframe, query, query.reach);
      },
      starts);
  std::vector<Viewpoint> distinct = query.expected;
  *starts += static_cast<int>(distinct.size());
  for (const Candidate& candidate : candidates) {
    if (distinct.size() >= query.expected.size() + kRefined) break;
    const bool is_new = std::none_of(distinct.begin(), distinct.end(), [&](const Viewpoint& start) {
      return are_consistent(start.travelled, candidate.from.travelled) &&
             pose_distance(start.world_from_camera, candidate.from.world_from_camera) < kDistinct;
    });
    if (is_new) distinct.push_back(candidate.from);
  }
  return distinct;
}

/// The frame registered coarsely to the possible keyframes that look like it, the best first.
template <class IsPossible>
std::vector<Relocaliser::Candidate> Relocaliser::from_keyframes(const PlaceQuery& query, const IsPossible& is_possible,
                                                                int* starts) const {
  const std::vector<const Keyframe*> nearest =
      keyframes_.nearest(keyframes_.encode(query.view.live), kNearest, is_possible);
  std::vector<Candidate> candidates;
  for (const Keyframe* keyframe : nearest) {
    load(*keyframe);
    for (const SE3& start : starts_at(*keyframe, query)) {
      RegistrationInput input;
      input.world_from_model = keyframe->from.world_from_camera;
      input.world_from_camera_seed = start;
      input.terms = query.terms;
      const TrackingResult result = register_frame(*backend_, query.view.live, keyframe_levels_, input, coarse_);
      ++*starts;
      if (result.rank == 6 && result.world_from_camera.is_finite())
        candidates.push_back({{result.world_from_camera, keyframe->from.travelled}, agreement(result)});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.agreement > b.agreement; });
  return candidates;
}

/// Whether the sensor lets the camera look there. One that has no heading says whether the camera is tilted alike.
bool Relocaliser::is_in_sight(const Keyframe& keyframe, const PlaceQuery& query) const {
  if (!keyframe.earth_from_camera || !query.view.earth_from_camera) return true;
  const Eigen::Matrix3d &then = *keyframe.earth_from_camera, &now = *query.view.earth_from_camera;
  const double difference = has_heading_ ? so3::angle(then.transpose() * now)
                                         : std::acos(std::clamp(up_in_camera(then).dot(up_in_camera(now)), -1.0, 1.0));
  return difference <= radians(kMaxAttitudeDifference);
}

/// The keyframe's pose, and the same place with the attitude that the sensor says.
std::vector<SE3> Relocaliser::starts_at(const Keyframe& keyframe, const PlaceQuery& query) const {
  const SE3& world_from_keyframe = keyframe.from.world_from_camera;
  std::vector<SE3> starts = {world_from_keyframe};
  if (!keyframe.earth_from_camera || !query.view.earth_from_camera) return starts;
  const Eigen::Matrix3d &then = *keyframe.earth_from_camera, &now = *query.view.earth_from_camera;
  const Eigen::Matrix3d then_from_now =
      has_heading_ ? Eigen::Matrix3d(then.transpose() * now)
                   : Eigen::Quaterniond::FromTwoVectors(up_in_camera(now), up_in_camera(then)).toRotationMatrix();
  starts.emplace_back(world_from_keyframe.rotation() * then_from_now, world_from_keyframe.translation());
  return starts;
}

/// The keyframe's maps to the device; normals follow from the depth.
void Relocaliser::load(const Keyframe& keyframe) const {
  for (std::size_t level = 0; level < keyframe_levels_.size(); ++level) {
    DepthLevel& out = keyframe_levels_[level];
    upload(*backend_, keyframe.depth[level], out.depth);
    estimate_normals(*backend_, out);
  }
}

/// Twice to the model as it is seen from where the frame seems to be.
FoundPlace Relocaliser::refine(const Viewpoint& start, const PlaceQuery& query) const {
  FoundPlace place;
  SE3 pose = start.world_from_camera;
  TrackingResult result;
  for (int round = 0; round < 2; ++round) {
    place.seed = {pose, start.travelled};
    render_(place.seed, &model_levels_);
    RegistrationInput input;
    input.world_from_model = input.world_from_camera_seed = pose;
    input.terms = query.terms;
    result = register_frame(*backend_, query.view.live, model_levels_, input, tracking_);
    if (result.rank < 6 || !result.world_from_camera.is_finite()) {
      result.inliers = 0;  // explains nothing
      result.world_from_camera = pose;
      break;
    }
    pose = result.world_from_camera;
  }
  place.evidence = look(query.view.live, result, start.travelled);
  return place;
}

ModelConsistency Relocaliser::check_consistency() const {
  ModelConsistency sums;
  std::vector<double> see_through;
  const std::vector<Keyframe>& all = keyframes_.all();
  const std::size_t count = std::min(all.size(), kMaxCompared);
  for (std::size_t i = 0; i < count; ++i) {
    const Keyframe& keyframe = all[i * all.size() / count];
    load(keyframe);
    render_(keyframe.from, &model_levels_);
    const DepthLevel& model = model_levels_[model_levels_.size() - keyframe_levels_.size()];
    const DepthComparison depth = backend_->reduce(
        kernels::CompareDepth{read_only(keyframe_levels_.front().depth), read_only(model.depth), kBehind, kOn});
    sums.known += depth.known();
    if (depth.known() == 0) continue;
    sums.matched += depth.matched();
    see_through.push_back(depth.see_through());
  }
  return mean_over_views(sums, std::move(see_through), count);
}

}  // namespace plumbline
