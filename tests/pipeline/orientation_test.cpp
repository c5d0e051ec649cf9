// What an orientation sensor changes in whole runs, on an analytic scene.
#include <gtest/gtest.h>

#include <map>
#include <numbers>

#include "pipeline/runs.h"
#include "plumbline/angles.h"
#include "plumbline/config.h"
#include "plumbline/evaluation.h"
#include "plumbline/frame.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "plumbline/trajectory.h"
#include "sensor/error_model.h"
#include "sim/analytic_scene.h"

namespace plumbline {
namespace {

const Pinhole kCamera = {131.25f, 131.25f, 79.5f, 59.5f, 160, 120};

Parameters small(std::string_view name) {
  Parameters p = preset(name);
  p.volume.resolution = 160;
  p.volume.side = 3.5;
  p.volume.offset = -0.1;
  p.volume.truncation = 0.08;
  return p;
}

/// A camera at the orbit's start that turns to and fro about two axes, `step` degrees a frame.
class Turning {
 public:
  Turning(double step, int frames) {
    const SE3 start = sim::orbit().front().world_from_camera;
    for (int i = 0; i < frames; ++i) {
      const double phase = 2 * std::numbers::pi * i / 24,
                   reach = step * 24 / (2 * std::numbers::pi) * kRadiansPerDegree;
      const Eigen::Matrix3d turn = so3::exp({0.4 * reach * std::sin(2 * phase), reach * std::sin(phase), 0});
      truth_.push_back({from_seconds(1 + i / 30.0), SE3(start.rotation() * turn, start.translation())});
      frames_.push_back(sim::render(scene_, kCamera, truth_.back().world_from_camera, truth_.back().time));
      frames_.back().index = i;
    }
  }

  int size() const { return static_cast<int>(frames_.size()); }
  const Trajectory& truth() const { return truth_; }

  /// A frame without a reading, or with what `reading` makes of the true orientation.
  template <class Reading>
  Frame frame(int i, const Reading& reading) const {
    Frame f = frames_[static_cast<std::size_t>(i)];
    f.earth_from_camera = reading(truth_[static_cast<std::size_t>(i)].world_from_camera.rotation(), i);
    return f;
  }

  template <class Reading>
  test::Run run(const Parameters& parameters, const Reading& reading) const {
    return test::run_pipeline(
        parameters, kCamera, size(), [&](int i) { return frame(i, reading); }, 1, truth_.front().world_from_camera);
  }

  double ate(const test::Run& run) const {
    return eval::absolute_trajectory_error(truth_, run.trajectory).translation.rmse;
  }

 private:
  sim::AnalyticScene scene_ = sim::desk_corner();
  Trajectory truth_;
  std::vector<Frame> frames_;
};

using Reading = std::optional<Eigen::Matrix3d>;
const Eigen::Matrix3d kEarthFromWorld = so3::exp({-1.4, 0.2, 0.9});
Reading none(const Eigen::Matrix3d&, int) { return std::nullopt; }
Reading ideal(const Eigen::Matrix3d& r, int) { return Eigen::Matrix3d(kEarthFromWorld * r); }

std::map<OrientationUse, int> uses(const test::Run& run) {
  std::map<OrientationUse, int> count;
  for (const FrameReport& report : run.reports) ++count[report.orientation];
  return count;
}

const Turning& slow() {
  static const Turning turning(1.5, 48);
  return turning;
}
const Turning& fast() {
  static const Turning turning(11, 36);
  return turning;
}

TEST(Orientation, KeepsTrackWhereTheBaselineLosesIt) {
  const test::Run baseline = fast().run(small("kinectfusion"), none);
  const bool failed = baseline.lost > 3 || fast().ate(baseline) > 0.05;
  EXPECT_TRUE(failed) << "the motion is too easy for this test";
  for (const char* name : {"plumbline", "paper"}) {
    const test::Run aided = fast().run(small(name), ideal);
    EXPECT_EQ(aided.lost, 0) << name;
    EXPECT_LT(fast().ate(aided), 0.02) << name;
    EXPECT_EQ(uses(aided)[OrientationUse::used], fast().size() - 1) << name;
    EXPECT_EQ(uses(aided)[OrientationUse::first], 1) << name;
  }
}

TEST(Orientation, AChipsErrorIsForgiven) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const SystematicError error(error_model("bno055").amplitude, 3, seed);
    const test::Run run = fast().run(small("plumbline"), [&](const Eigen::Matrix3d& r, int) -> Reading {
      const Eigen::Matrix3d earth_from_camera = kEarthFromWorld * r;
      return Eigen::Matrix3d(so3::exp(error.at(earth_from_camera)) * earth_from_camera);
    });
    EXPECT_EQ(run.lost, 0) << seed;
    EXPECT_LT(fast().ate(run), 0.03) << seed;
  }
}

TEST(Orientation, WithoutASensorTheCameraIsExpectedToGoOnTurningOrToStay) {
  Parameters staying = small("plumbline");
  staying.tracking.speed_memory = 0;
  staying.motion.steady = false;
  for (const Parameters& parameters : {small("plumbline"), staying}) {
    const test::Run run = slow().run(parameters, none);
    EXPECT_EQ(run.lost, 0);
    EXPECT_LT(slow().ate(run), 0.01);
    EXPECT_EQ(uses(run)[OrientationUse::missing], slow().size());
    const FrameReport &fifth = run.reports[5], &last = run.reports[4];
    const double turned =
        so3::angle(last.world_from_camera.rotation().transpose() * fifth.world_from_camera.rotation());
    EXPECT_GT(turned, 0.3 * kRadiansPerDegree);
    if (parameters.tracking.speed_memory > 0) {
      EXPECT_NEAR(fifth.seed_angle, turned, 0.3 * turned);
      EXPECT_LT(fifth.seed_to_result_angle, turned) << "nearer than the previous pose";
    } else {
      EXPECT_EQ(fifth.seed_angle, 0);
      EXPECT_NEAR(fifth.seed_to_result_angle, turned, 1e-9);
    }
  }
}

TEST(Orientation, TheBaselineDoesNotLookAtIt) {
  const test::Run with = slow().run(small("kinectfusion"), ideal), without = slow().run(small("kinectfusion"), none);
  EXPECT_EQ(uses(with)[OrientationUse::off], slow().size());
  EXPECT_EQ(with.trajectory.back().world_from_camera.translation(),
            without.trajectory.back().world_from_camera.translation());
}

TEST(Orientation, AGapIsBridgedByTheBaseline) {
  const test::Run run = slow().run(small("plumbline"), [](const Eigen::Matrix3d& r, int i) -> Reading {
    if (i >= 10 && i < 25) return std::nullopt;
    return ideal(r, i);
  });
  EXPECT_EQ(run.lost, 0);
  EXPECT_EQ(uses(run)[OrientationUse::missing], 15);
  EXPECT_LT(slow().ate(run), 0.01);
}

TEST(Orientation, AStreamThatStartsLateIsTiedToTheWorldThen) {
  const test::Run run = slow().run(small("plumbline"), [](const Eigen::Matrix3d& r, int i) -> Reading {
    if (i < 12) return std::nullopt;
    return ideal(r, i);
  });
  EXPECT_EQ(run.reports[12].orientation, OrientationUse::first);
  EXPECT_EQ(run.reports[13].orientation, OrientationUse::used);
  EXPECT_LT(slow().ate(run), 0.01);
}

TEST(Orientation, GarbageIsFoundOutAndDoesNoHarm) {
  const double baseline = slow().ate(slow().run(small("plumbline"), none));
  const Eigen::Matrix3d half_turn = so3::exp({0, 0, std::numbers::pi});
  const std::map<std::string, std::function<Reading(const Eigen::Matrix3d&, int)>> garbage = {
      {"constant", [](const Eigen::Matrix3d&, int) -> Reading { return kEarthFromWorld; }},
      {"inverse", [](const Eigen::Matrix3d& r, int) -> Reading { return Eigen::Matrix3d(r.transpose()); }},
      {"mounting", [&](const Eigen::Matrix3d& r, int) -> Reading { return Eigen::Matrix3d(r * half_turn); }}};
  for (const auto& [name, reading] : garbage) {
    const test::Run run = slow().run(small("plumbline"), reading);
    EXPECT_EQ(run.lost, 0) << name;
    EXPECT_LE(slow().ate(run), 1.1 * baseline + 1.5e-3) << name;
    EXPECT_GT(uses(run)[OrientationUse::distrusted], slow().size() / 2) << name;
  }
}

TEST(Orientation, EveryPartIsASwitch) {
  // Each with each: all of them track this.
  for (const char* seed : {"none", "absolute", "relative"}) {
    for (const char* term : {"none", "damping", "anchor"}) {
      // Damping without a seed holds the camera to its last orientation: that is what it is.
      if (std::string_view(seed) == "none" && std::string_view(term) == "damping") continue;
      Parameters parameters = small("plumbline");
      apply_setting(std::string("orientation.seed=") + seed, &parameters);
      apply_setting(std::string("orientation.term=") + term, &parameters);
      const test::Run run = slow().run(parameters, ideal);
      EXPECT_EQ(run.lost, 0) << seed << ", " << term;
      EXPECT_LT(slow().ate(run), 0.015) << seed << ", " << term;
    }
  }
}

}  // namespace
}  // namespace plumbline
