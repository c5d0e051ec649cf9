// Registration of a frame against a model predicted from a volume: known motions, hooks, and every way to be lost.
#include "tracking/registration.h"

#include <gtest/gtest.h>

#include <numeric>

#include "map/volume.h"
#include "plumbline/angles.h"
#include "plumbline/image.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "support/scenes.h"
#include "tracking/live_frame.h"

namespace plumbline {
namespace {

TrackingParameters baseline() { return preset("kinectfusion").tracking; }

/// What one residual of these images weighs beside a prior, at every level.
double residual_weight() { return registration_information(baseline(), 320 * 240); }

/// A scene fused from one pose and predicted from it, and what is tracked against it.
class Model {
 public:
  Model(const sim::AnalyticScene& scene, const SE3& world_from_model, int levels = 3)
      : scene_(scene), world_from_model_(world_from_model), model_(make_pyramid(camera(), levels, *backend_)) {
    VolumeParameters parameters = preset("kinectfusion").volume;
    parameters.resolution = 128;
    parameters.side = 3;
    parameters.truncation = 0.07;
    Volume volume(parameters, camera(), *backend_, false);
    volume.place(place_volume(parameters, camera(), world_from_model, Image<float>()));
    volume.integrate(test::to_plane(*backend_, test::view_of(scene, camera(), world_from_model).depth), nullptr,
                     camera(), world_from_model);
    volume.predict(world_from_model, RaycastRange(), &model_);
  }

  /// Tracks what a camera at `world_from_camera` sees, to the last bit: readings of 1/5000 m would be noise.
  TrackingResult track(const SE3& world_from_camera, RegistrationInput input = {},
                       const TrackingParameters& parameters = baseline()) const {
    const test::View view = test::view_of(scene_, camera(), world_from_camera);
    return track_depth(view.depth, input, parameters);
  }

  TrackingResult track_depth(const Image<float>& depth, RegistrationInput input,
                             const TrackingParameters& parameters) const {
    DepthPyramid live = make_pyramid(camera(), 3, *backend_);
    upload(*backend_, depth, live.front().depth);
    for (std::size_t l = 0; l < live.size(); ++l) {
      if (l > 0) backend_->run(kernels::DecimateDepth{read_only(live[l - 1].depth), live[l].depth.view(), 0.09f});
      estimate_plane_normals(*backend_, live[l], 3, 0.03f);
    }
    input.world_from_model = world_from_model_;
    return register_frame(*backend_, live, model_, input, parameters);
  }

  /// The same prediction without its finest image.
  Model without_finest_level() const {
    Model coarse(scene_, world_from_model_);
    coarse.model_.erase(coarse.model_.begin());
    return coarse;
  }

  static Pinhole camera() { return test::pinhole(320, 240); }
  const SE3& world_from_model() const { return world_from_model_; }
  RegistrationInput seed() const { return seed(world_from_model_); }
  RegistrationInput seed(const SE3& world_from_camera) const {
    RegistrationInput input;
    input.world_from_camera_seed = world_from_camera;
    return input;
  }

 private:
  std::shared_ptr<Backend> backend_ = make_backend("cpu", 1);
  sim::AnalyticScene scene_;
  SE3 world_from_model_;
  DepthPyramid model_;
};

const Model& desk() {
  static const Model model(sim::desk_corner(), sim::orbit().front().world_from_camera);
  return model;
}

void expect_near(const SE3& estimate, const SE3& truth, double metres, double degrees) {
  const SE3 error = truth.inverse() * estimate;
  EXPECT_LT(error.translation().norm(), metres);
  EXPECT_LT(so3::angle(error.rotation()), degrees * kRadiansPerDegree);
}

// ---- known motions --------------------------------------------------------------------------------------------------

TEST(Registration, StaysWhereItIs) {
  const TrackingResult result = desk().track(desk().world_from_model(), desk().seed());
  EXPECT_EQ(result.status, TrackingStatus::tracked);
  EXPECT_EQ(result.reason, LostReason::none);
  expect_near(result.world_from_camera, desk().world_from_model(), 1e-3, 0.05);
}

TEST(Registration, RecoversKnownMotions) {
  for (unsigned i = 0; i < 8; ++i) {
    const bool large = i % 2 == 1;
    const SE3 motion = test::Random(20 + i).motion((large ? 3 : 1) * kRadiansPerDegree, large ? 0.05 : 0.02);
    const SE3 truth = desk().world_from_model() * motion;
    const TrackingResult result = desk().track(truth, desk().seed());
    ASSERT_EQ(result.status, TrackingStatus::tracked) << i;
    expect_near(result.world_from_camera, truth, 1e-3, 0.05);
    EXPECT_EQ(result.rank, 6);
    EXPECT_GT(result.condition, 1);
    EXPECT_LT(result.condition, 1e4);
    EXPECT_EQ(result.iterations, (std::vector<int>{4, 5, 10}));
    EXPECT_GT(result.inliers, 320 * 240 / 2);
    EXPECT_GT(result.inlier_fraction, 0.6);
    EXPECT_LE(result.inlier_fraction, 1);
    EXPECT_LT(result.rms, 4e-3);
    EXPECT_LT(result.median_distance, 0.02);
  }
}

TEST(Registration, ABetterSeedIsNoWorse) {
  const SE3 truth = desk().world_from_model() * test::Random(4).motion(8 * kRadiansPerDegree, 0.02);
  const TrackingResult seeded = desk().track(truth, desk().seed(truth));
  ASSERT_EQ(seeded.status, TrackingStatus::tracked);
  expect_near(seeded.world_from_camera, truth, 1e-3, 0.05);
}

TEST(Registration, StopsAtTheFinestLevelAskedFor) {
  TrackingParameters parameters = preset("kinectfusion").tracking;
  parameters.iterations = {6, 6};
  parameters.finest_level = 1;
  EXPECT_EQ(pyramid_levels(parameters), 3);
  const SE3 truth = desk().world_from_model() * test::Random(6).motion(1 * kRadiansPerDegree, 0.02);
  const TrackingResult result = desk().track(truth, desk().seed(), parameters);
  ASSERT_EQ(result.status, TrackingStatus::tracked);
  expect_near(result.world_from_camera, truth, 2e-3, 0.1);
  EXPECT_EQ(result.iterations, (std::vector<int>{6, 6}));
  EXPECT_GT(result.inliers, 320 * 240 / 2) << "in pixels of the full image";
  EXPECT_LE(result.inliers, 320 * 240);
}

TEST(Registration, ALevelWithoutIterationsIsSkipped) {
  TrackingParameters parameters = preset("kinectfusion").tracking;
  parameters.iterations = {0, 4, 6};
  const SE3 truth = desk().world_from_model() * test::Random(7).motion(1 * kRadiansPerDegree, 0.02);
  const TrackingResult result = desk().track(truth, desk().seed(), parameters);
  EXPECT_EQ(result.iterations, parameters.iterations);
  expect_near(result.world_from_camera, truth, 1e-3, 0.05);
}

// ---- lost -----------------------------------------------------------------------------------------------------------

TEST(Registration, ASinglePlaneIsSingular) {
  // Seen at a slant: its depth changes over the image, but sliding along it changes nothing.
  const SE3 pose = sim::look_at({0, 0, 1.5}, {0.8, 0.5, 0});
  const Model wall({{sim::plane({0, 0, 0}, {0, 0, 1})}}, pose);
  const TrackingResult result = wall.track(pose * test::Random(1).motion(0.5 * kRadiansPerDegree, 0.01), wall.seed());
  EXPECT_EQ(result.status, TrackingStatus::lost);
  EXPECT_EQ(result.reason, LostReason::singular);
  EXPECT_LT(result.rank, 6);
}

TEST(Registration, AnEmptyModelHasFewInliers) {
  const Model nothing({}, SE3());
  const Image<float> depth = test::view_of(sim::desk_corner(), Model::camera(), desk().world_from_model()).depth;
  const TrackingResult result = nothing.track_depth(depth, nothing.seed(), baseline());
  EXPECT_EQ(result.status, TrackingStatus::lost);
  EXPECT_EQ(result.reason, LostReason::few_inliers);
  EXPECT_EQ(result.inliers, 0);
  EXPECT_EQ(result.rms, 0);
  EXPECT_EQ(result.median_distance, 0);
  EXPECT_EQ(result.iterations, (std::vector<int>{1, 1, 1})) << "nothing to iterate on";
  EXPECT_TRUE(result.world_from_camera.is_finite());
  expect_near(result.world_from_camera, SE3(), 1e-12, 1e-9);
}

TEST(Registration, AnEmptyFrameHasFewInliers) {
  const Pinhole k = Model::camera();
  const TrackingResult result = desk().track_depth(Image<float>(k.width, k.height), desk().seed(), baseline());
  EXPECT_EQ(result.status, TrackingStatus::lost);
  EXPECT_EQ(result.reason, LostReason::few_inliers);
  EXPECT_EQ(result.inlier_fraction, 0);
  EXPECT_TRUE(result.world_from_camera.is_finite());
}

TEST(Registration, AnotherSceneHasFewInliers) {
  const sim::AnalyticScene sphere{{sim::sphere(desk().world_from_model() * Eigen::Vector3d(0, 0, 0.6), 0.1)}};
  const Image<float> depth = test::view_of(sphere, Model::camera(), desk().world_from_model()).depth;
  const TrackingResult result = desk().track_depth(depth, desk().seed(), baseline());
  EXPECT_EQ(result.reason, LostReason::few_inliers);
}

TEST(Registration, TheLimitsOfInliersDecide) {
  const SE3& pose = desk().world_from_model();
  TrackingParameters parameters = preset("kinectfusion").tracking;
  const TrackingResult free = desk().track(pose, desk().seed(), parameters);
  ASSERT_EQ(free.status, TrackingStatus::tracked);
  parameters.min_inlier_fraction = std::min(1.0, free.inlier_fraction + 0.02);
  EXPECT_EQ(desk().track(pose, desk().seed(), parameters).reason, LostReason::few_inliers);
}

TEST(Registration, AStepThatIsTooLongIsImplausible) {
  const SE3 truth = desk().world_from_model() * test::Random(9).motion(2 * kRadiansPerDegree, 0.04);
  TrackingParameters parameters = preset("kinectfusion").tracking;
  parameters.max_step_translation = 0.03;
  const TrackingResult moved = desk().track(truth, desk().seed(), parameters);
  EXPECT_EQ(moved.status, TrackingStatus::lost);
  EXPECT_EQ(moved.reason, LostReason::implausible_step);
  expect_near(moved.world_from_camera, truth, 1e-3, 0.05);
  parameters.max_step_translation = 0.05;
  EXPECT_EQ(desk().track(truth, desk().seed(), parameters).status, TrackingStatus::tracked);
  parameters.max_step_rotation = 1.5;
  EXPECT_EQ(desk().track(truth, desk().seed(), parameters).reason, LostReason::implausible_step);
  // The step is counted from the seed, not from the model.
  EXPECT_EQ(desk().track(truth, desk().seed(truth), parameters).status, TrackingStatus::tracked);
}

TEST(Registration, EveryStatusAndReasonHasAName) {
  EXPECT_EQ(to_string(TrackingStatus::initialised), "initialised");
  EXPECT_EQ(to_string(TrackingStatus::tracked), "tracked");
  EXPECT_EQ(to_string(TrackingStatus::lost), "lost");
  EXPECT_EQ(to_string(LostReason::none), "");
  EXPECT_EQ(to_string(LostReason::no_depth), "no depth");
  EXPECT_EQ(to_string(LostReason::few_inliers), "few inliers");
  EXPECT_EQ(to_string(LostReason::singular), "singular");
  EXPECT_EQ(to_string(LostReason::implausible_step), "implausible step");
}

// ---- the prior ------------------------------------------------------------------------------------------------------

/// Pulls the rotation, and the position if it has a weight, to a known pose.
/// The weights are those of so many residuals.
kernels::Terms terms_towards(const SE3& world_from_camera, double rotation_weight, double translation_weight) {
  const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
  kernels::Terms terms;
  terms.set(kernels::OrientationAnchor{world_from_camera.rotation(), unit, residual_weight() * rotation_weight * unit});
  if (translation_weight > 0)
    terms.set(
        kernels::TranslationPrior{world_from_camera.translation(), residual_weight() * translation_weight * unit});
  return terms;
}

TEST(RegistrationTerms, AStrongRotationHolds) {
  const SE3 truth = desk().world_from_model() * test::Random(10).motion(1 * kRadiansPerDegree, 0.02);
  const SE3 expected(so3::exp({0.01, -0.005, 0.008}) * desk().world_from_model().rotation(),
                     desk().world_from_model().translation());
  RegistrationInput input = desk().seed();
  input.terms = terms_towards(expected, 1e8, 0);
  const TrackingResult result = desk().track(truth, input, baseline());
  EXPECT_EQ(result.status, TrackingStatus::tracked);
  EXPECT_LT(so3::angle(expected.rotation().transpose() * result.world_from_camera.rotation()),
            0.002 * kRadiansPerDegree);
  // Without it the rotation is that of the images.
  const TrackingResult free = desk().track(truth, desk().seed());
  EXPECT_GT(so3::angle(expected.rotation().transpose() * free.world_from_camera.rotation()), 0.3 * kRadiansPerDegree);
}

TEST(RegistrationTerms, AWeightOfNothingChangesNothing) {
  const SE3 truth = desk().world_from_model() * test::Random(11).motion(1 * kRadiansPerDegree, 0.02);
  RegistrationInput input = desk().seed();
  input.terms = terms_towards(SE3(), 0, 0);
  const SE3 with = desk().track(truth, input).world_from_camera;
  const SE3 without = desk().track(truth, desk().seed()).world_from_camera;
  EXPECT_EQ(with.rotation(), without.rotation());
  EXPECT_EQ(with.translation(), without.translation());
}

TEST(RegistrationTerms, IncrementsAreOnTheLeftInTheWorldsFrame) {
  // A prior that outweighs the images must be reached: in one step its rotation, exactly, and its position but for the
  // step's curvature. The registration's own increments are in the model's frame, which is turned and moved against the
  // world's.
  const SE3 seed = desk().world_from_model() * test::Random(12).motion(0.5 * kRadiansPerDegree, 0.01);
  const SE3 goal = test::Random(13).motion(3 * kRadiansPerDegree, 0.05) * seed;
  ASSERT_GT(so3::angle(desk().world_from_model().rotation()), 0.5);
  ASSERT_GT(desk().world_from_model().translation().norm(), 0.5);
  RegistrationInput input = desk().seed(seed);
  input.terms = terms_towards(goal, 1e14, 1e14);
  TrackingParameters parameters = baseline();
  parameters.iterations = {0, 0, 1};
  expect_near(desk().track(desk().world_from_model(), input, parameters).world_from_camera, goal, 2e-3, 1e-5);
  parameters.iterations = {0, 0, 3};
  expect_near(desk().track(desk().world_from_model(), input, parameters).world_from_camera, goal, 1e-7, 1e-5);
}

TEST(RegistrationTerms, AStepLowersTheCost) {
  const SE3 goal = test::Random(14).motion(2 * kRadiansPerDegree, 0.03) * desk().world_from_model();
  const auto cost = [&](const SE3& t) {
    return 0.5 * (3 * so3::log(t.rotation() * goal.rotation().transpose()).squaredNorm() +
                  5 * (t.translation() - goal.translation()).squaredNorm());
  };
  RegistrationInput input = desk().seed();
  input.terms = terms_towards(goal, 3e12, 5e12);
  TrackingParameters parameters = baseline();
  parameters.iterations = {0, 0, 3};
  const SE3 pose = desk().world_from_model();
  EXPECT_LT(cost(desk().track(pose, input, parameters).world_from_camera), 1e-6 * cost(pose));
}

TEST(RegistrationTerms, IsToldWhatTheAssociationFound) {
  // Damping grows with the matched pixels and shrinks the step accordingly: (H + 2λn I/κσ²) ω = b/κσ² in each
  // iteration.
  const SE3 truth = desk().world_from_model() * test::Random(15).motion(1 * kRadiansPerDegree, 0.02);
  RegistrationInput input = desk().seed();
  input.terms.set(kernels::RotationDamping{LambdaSchedule::inverse, 0.3});
  std::vector<IcpIteration> trace;
  input.trace = &trace;
  const TrackingResult result = desk().track(truth, input);
  ASSERT_EQ(trace.size(), 19u) << "4 + 5 + 10";
  EXPECT_EQ(trace.back().matched, result.inliers);
  for (std::size_t i = 0; i < trace.size(); ++i) {
    const int level = i < 4 ? 2 : (i < 9 ? 1 : 0), pixels = (320 >> level) * (240 >> level);
    EXPECT_EQ(trace[i].level, level) << i;
    EXPECT_DOUBLE_EQ(trace[i].matched_fraction * pixels, trace[i].matched) << i;
    EXPECT_GT(trace[i].matched, pixels / 3) << i;
    EXPECT_LE(trace[i].matched, pixels) << i;
  }
  RegistrationInput free = desk().seed();
  std::vector<IcpIteration> undamped;
  free.trace = &undamped;
  desk().track(truth, free);
  EXPECT_EQ(trace.front().matched, undamped.front().matched) << "the same start";
  EXPECT_LT(trace.front().step.head<3>().norm(), 0.9 * undamped.front().step.head<3>().norm());
  const auto missed = [&](const SE3& pose) { return (pose.inverse() * truth).translation().norm(); };
  EXPECT_LT(missed(trace.back().world_from_camera), 0.3 * missed(desk().world_from_model())) << "yet it gets there";
}

// ---- convergence ----------------------------------------------------------------------------------------------------

TEST(RegistrationConvergence, EndsALevelOnceTheMedianStandsStill) {
  TrackingParameters parameters = preset("kinectfusion").tracking;
  parameters.iterations = {20, 20, 20};
  parameters.converged_after = 3;
  std::vector<IcpIteration> trace;
  RegistrationInput input = desk().seed();
  input.trace = &trace;
  const SE3 truth = desk().world_from_model() * test::Random(16).motion(1 * kRadiansPerDegree, 0.02);
  const TrackingResult result = desk().track(truth, input, parameters);
  ASSERT_EQ(result.status, TrackingStatus::tracked);
  expect_near(result.world_from_camera, truth, 2e-3, 0.1);
  std::size_t end = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto count = static_cast<std::size_t>(result.iterations[i]);
    EXPECT_GE(count, 3u);
    EXPECT_LT(count, 20u) << "level " << 2 - i << " never converged";
    end += count;
    ASSERT_LE(end, trace.size());
    EXPECT_EQ(trace[end - 1].median_distance, trace[end - 2].median_distance);
    EXPECT_EQ(trace[end - 1].median_distance, trace[end - 3].median_distance);
    EXPECT_TRUE(count == 3 || trace[end - 4].median_distance != trace[end - 3].median_distance);
  }
  EXPECT_EQ(end, trace.size());
}

TEST(RegistrationConvergence, TheParametersRemainTheLimit) {
  TrackingParameters parameters = preset("kinectfusion").tracking;
  parameters.converged_after = 1000;
  const SE3 truth = desk().world_from_model() * test::Random(16).motion(1 * kRadiansPerDegree, 0.02);
  const TrackingResult result = desk().track(truth, desk().seed(), parameters);
  EXPECT_EQ(result.iterations, (std::vector<int>{4, 5, 10}));
  expect_near(result.world_from_camera, truth, 1e-3, 0.05);
}

TEST(RegistrationConvergence, GoesOnWhileTheStepIsLarge) {
  TrackingParameters parameters = baseline();
  parameters.iterations = {1, 1, 1};
  parameters.converged_step = 1e-4;
  parameters.max_iterations = 30;
  std::vector<int> made;
  for (const double size : {0.0, 1.0, 3.0}) {
    const SE3 truth = desk().world_from_model() * test::Random(21).motion(size * kRadiansPerDegree, 0.05 / 3 * size);
    std::vector<IcpIteration> trace;
    RegistrationInput input = desk().seed();
    input.trace = &trace;
    const TrackingResult result = desk().track(truth, input, parameters);
    ASSERT_EQ(result.status, TrackingStatus::tracked) << size;
    expect_near(result.world_from_camera, truth, 1e-3, 0.05);
    const auto moved = [](const IcpIteration& i) { return 1.5 * i.step.head<3>().norm() + i.step.tail<3>().norm(); };
    std::size_t end = 0;
    for (std::size_t level = 0; level < 3; ++level) {
      const auto count = static_cast<std::size_t>(result.iterations[level]);
      for (std::size_t i = end; i + 1 < end + count; ++i) EXPECT_GE(moved(trace[i]), 1e-4);
      end += count;
      EXPECT_TRUE(count == 30 || moved(trace[end - 1]) < 1e-4);
    }
    made.push_back(static_cast<int>(end));
  }
  EXPECT_LT(made[0], made[2]) << "what has not moved needs less";
  EXPECT_LT(made[0], 12);
}

TEST(RegistrationConvergence, GoesNoFartherThanAllowed) {
  TrackingParameters parameters = preset("kinectfusion").tracking;
  parameters.iterations = {1, 0, 2};
  parameters.converged_step = 1e-12;
  parameters.max_iterations = 4;
  const SE3 truth = desk().world_from_model() * test::Random(16).motion(1 * kRadiansPerDegree, 0.02);
  EXPECT_EQ(desk().track(truth, desk().seed(), parameters).iterations, (std::vector<int>{4, 0, 4}));
}

// ---- what an iteration tells ----------------------------------------------------------------------------------------

TEST(RegistrationTrace, IsThatOfTheRun) {
  std::vector<IcpIteration> trace;
  RegistrationInput input = desk().seed();
  input.trace = &trace;
  const SE3 truth = desk().world_from_model() * test::Random(17).motion(2 * kRadiansPerDegree, 0.03);
  const TrackingResult result = desk().track(truth, input);
  ASSERT_EQ(trace.size(), 19u);
  EXPECT_EQ(trace.front().level, 2);
  EXPECT_EQ(trace.back().level, 0);
  EXPECT_EQ(trace.back().matched, result.inliers);
  EXPECT_EQ(trace.back().median_distance, result.median_distance);
  EXPECT_LT(trace.back().step.norm(), 1e-3 * trace.front().step.norm());
  expect_near(trace.back().world_from_camera, result.world_from_camera, 1e-12, 1e-9);
  for (const IcpIteration& iteration : trace) {
    EXPECT_EQ(std::accumulate(iteration.histogram.begin(), iteration.histogram.end(), 0), iteration.pairs);
    EXPECT_GE(iteration.pairs, iteration.matched);
  }
}

// ---- the median filter ----------------------------------------------------------------------------------------------

TEST(RegistrationMedianFilter, LeavesOutWhatLiesFarFromTheMedian) {
  const SE3 truth = desk().world_from_model() * test::Random(18).motion(2 * kRadiansPerDegree, 0.04);
  TrackingParameters wide = baseline(), filtered = baseline();
  wide.distance_gate = filtered.distance_gate = 0.5;
  filtered.median_filter = true;
  filtered.median_band = 0.02;
  std::vector<IcpIteration> all, some;
  RegistrationInput input = desk().seed();
  input.trace = &all;
  desk().track(truth, input, wide);
  input.trace = &some;
  const TrackingResult result = desk().track(truth, input, filtered);
  // In the first iteration both see the same pairs, and the histogram tells how many lie in the band.
  ASSERT_EQ(all.front().histogram, some.front().histogram);
  const double median = some.front().median_distance;
  double low = 0, high = 0;  // bins that lie inside whole, and those that touch the band
  for (std::size_t i = 0; i < some.front().histogram.size(); ++i) {
    const double from = static_cast<double>(i) * 0.0005, to = from + 0.0005;
    if (from >= median - 0.02 && to <= median + 0.02) low += some.front().histogram[i];
    if (to >= median - 0.02 && from <= median + 0.02) high += some.front().histogram[i];
  }
  EXPECT_LT(some.front().matched, all.front().matched);
  EXPECT_LE(some.front().matched, high);
  EXPECT_GT(some.front().matched, 0.5 * low) << "normals and gates leave out some";
  EXPECT_EQ(result.status, TrackingStatus::tracked);
  expect_near(result.world_from_camera, truth, 1e-3, 0.05);
}

// ---- levels ---------------------------------------------------------------------------------------------------------

TEST(RegistrationGate, FollowsTheDistancesOfAFarSeed) {
  TrackingParameters narrow = baseline();
  narrow.distance_gate = 0.03;
  narrow.iterations = {10, 5, 5};
  TrackingParameters following = narrow;
  following.gate_per_median = 5;
  const SE3 truth = desk().world_from_model() * test::Random(25).motion(6 * kRadiansPerDegree, 0.08);
  const auto error = [&](const TrackingParameters& parameters) {
    const SE3 difference = truth.inverse() * desk().track(truth, desk().seed(), parameters).world_from_camera;
    return difference.translation().norm() + so3::angle(difference.rotation());
  };
  EXPECT_GT(error(narrow), 0.02) << "else this shows nothing";
  EXPECT_LT(error(following), 2e-3);
}

TEST(RegistrationLevels, TheModelNeedsNoLevelsThatAreNotTracked) {
  const SE3 truth = desk().world_from_model() * test::Random(19).motion(1 * kRadiansPerDegree, 0.02);
  TrackingParameters parameters = preset("kinectfusion").tracking;
  parameters.iterations = {4, 6};
  parameters.finest_level = 1;
  const TrackingResult whole = desk().track(truth, desk().seed(), parameters);
  const TrackingResult part = desk().without_finest_level().track(truth, desk().seed(), parameters);
  EXPECT_EQ(whole.world_from_camera.translation(), part.world_from_camera.translation());
  EXPECT_EQ(whole.world_from_camera.rotation(), part.world_from_camera.rotation());
  expect_near(part.world_from_camera, truth, 2e-3, 0.1);
}

TEST(Registration, GatesAreThoseOfTheParameters) {
  TrackingParameters parameters = preset("kinectfusion").tracking;
  parameters.distance_gate = 0.07;
  parameters.normal_gate = 60;
  kernels::IcpInput in{};
  registration_rules(parameters).set_gates(SE3(so3::exp({0, 0, 0.1}), {1, 2, 3}), 0, &in);
  EXPECT_FLOAT_EQ(in.distance_gate, 0.07f);
  EXPECT_NEAR(in.cos_normal_gate, 0.5f, 1e-6f);
  EXPECT_EQ(in.bins, 1000);
  EXPECT_FLOAT_EQ(in.bins_per_metre, 2000);
  EXPECT_EQ(in.band_low, 0);
  EXPECT_GT(in.band_high, 1e30f);
  parameters.gate_per_median = 5;
  const auto gate_after = [&](double median) {
    registration_rules(parameters).set_gates(SE3(), median, &in);
    return in.distance_gate;
  };
  EXPECT_FLOAT_EQ(gate_after(0), 0.07f) << "nothing is known yet";
  EXPECT_FLOAT_EQ(gate_after(0.01), 0.07f) << "it never becomes narrower";
  EXPECT_FLOAT_EQ(gate_after(0.03), 0.15f);
  EXPECT_FLOAT_EQ(gate_after(0.3), 0.3f);
  registration_rules(parameters).set_gates(SE3(so3::exp({0, 0, 0.1}), {1, 2, 3}), 0, &in);
  EXPECT_FLOAT_EQ(in.model_from_live.t[2], 3);
  EXPECT_FLOAT_EQ(in.model_from_live.r[1], static_cast<float>(-std::sin(0.1)));
}

}  // namespace
}  // namespace plumbline
