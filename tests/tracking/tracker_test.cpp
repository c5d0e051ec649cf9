// The tracker's state is a value: kept, set back and gone on from, the same poses follow to the bit.
#include "tracking/tracker.h"

#include <gtest/gtest.h>

#include <memory>

#include "backend/backend.h"
#include "map/volume.h"
#include "plumbline/frame.h"
#include "plumbline/parameters.h"
#include "plumbline/pinhole.h"
#include "sim/analytic_scene.h"

namespace plumbline {
namespace {

const Pinhole kCamera = {131.25f, 131.25f, 79.5f, 59.5f, 160, 120};

Parameters small() {
  Parameters p = preset("plumbline");
  p.volume.resolution = 96;
  p.volume.side = 3.5;
  p.tracking.finest_level = 0;
  return p;
}

/// Frames along an orbit, each with a perfect sensor's reading, and the model that the first one made.
class TrackerTest : public testing::Test {
 protected:
  TrackerTest()
      : backend_(make_backend("cpu", 1)),
        live_(kCamera, parameters_.preprocess, pyramid_levels(parameters_.tracking), *backend_, false),
        model_{make_pyramid(kCamera, static_cast<int>(parameters_.tracking.iterations.size()), *backend_),
               path_.front().world_from_camera},
        tracker_(parameters_, model_.world_from_camera, *backend_) {
    const TrackedFrame first = step(tracker_, 0);
    EXPECT_TRUE(first.is_first());
    Volume volume(parameters_.volume, kCamera, *backend_, false);
    volume.place(
        place_volume(parameters_.volume, kCamera, model_.world_from_camera, download(*backend_, live_.raw_depth())));
    volume.integrate(live_.raw_depth(), nullptr, kCamera, model_.world_from_camera);
    volume.predict(model_.world_from_camera, raycast_range(parameters_.preprocess.max_depth), &model_.levels);
  }

  Frame frame(int i) const {
    const SE3& pose = path_[static_cast<std::size_t>(i)].world_from_camera;
    Frame frame = sim::render(scene_, kCamera, pose, from_seconds(1 + i / 30.0));
    frame.earth_from_camera = pose.rotation();
    return frame;
  }

  TrackedFrame step(Tracker& tracker, int i) {
    const Frame next = frame(i);
    live_.prepare(next);
    const TrackedFrame tracked = tracker.track({next, live_, model_});
    if (tracked.is_acceptable())
      tracker.accept(next, tracked);
    else
      tracker.reject(tracked);
    return tracked;
  }

  Parameters parameters_ = small();
  sim::AnalyticScene scene_ = sim::desk_corner();
  Trajectory path_ = sim::orbit();
  std::shared_ptr<Backend> backend_;
  LiveFrame live_;
  PredictedSurface model_;
  Tracker tracker_;
};

TEST_F(TrackerTest, GoesOnFromAStateThatWasKept) {
  for (int i = 1; i < 4; ++i) ASSERT_EQ(step(tracker_, i).result.status, TrackingStatus::tracked) << i;
  const TrackerState kept = tracker_.state();
  std::vector<SE3> poses;
  for (int i = 4; i < 7; ++i) poses.push_back(step(tracker_, i).result.world_from_camera);
  ASSERT_NE(tracker_.world_from_camera().translation(), kept.world_from_camera.translation());

  Tracker fresh(parameters_, SE3(), *backend_);  // of another pose and no history
  fresh.set_state(kept);
  tracker_.set_state(kept);
  for (int i = 4; i < 7; ++i) {
    const SE3& expected = poses[static_cast<std::size_t>(i - 4)];
    for (Tracker* tracker : {&fresh, &tracker_}) {
      const SE3 pose = step(*tracker, i).result.world_from_camera;
      EXPECT_EQ(pose.rotation(), expected.rotation()) << i;
      EXPECT_EQ(pose.translation(), expected.translation()) << i;
    }
  }
}

TEST_F(TrackerTest, TrackingAloneChangesNothing) {
  step(tracker_, 1);
  const Frame next = frame(2);
  live_.prepare(next);
  const SE3 once = tracker_.track({next, live_, model_}).result.world_from_camera;
  const SE3 again = tracker_.track({next, live_, model_}).result.world_from_camera;
  EXPECT_EQ(once.rotation(), again.rotation());
  EXPECT_EQ(once.translation(), again.translation());
  EXPECT_NE(once.translation(), tracker_.world_from_camera().translation()) << "not accepted yet";
}

TEST_F(TrackerTest, WithoutDepthTheFrameIsRejectedAndThePoseStays) {
  step(tracker_, 1);
  const SE3 previous = tracker_.world_from_camera();
  Frame blind = frame(2);
  blind.depth = Image<std::uint16_t>(kCamera.width, kCamera.height);
  live_.prepare(blind);
  const TrackedFrame tracked = tracker_.track({blind, live_, model_});
  EXPECT_FALSE(tracked.is_acceptable());
  EXPECT_EQ(tracked.result.reason, LostReason::no_depth);
  tracker_.reject(tracked);
  EXPECT_EQ(tracker_.world_from_camera().translation(), previous.translation());
  EXPECT_EQ(step(tracker_, 2).result.status, TrackingStatus::tracked);
}

}  // namespace
}  // namespace plumbline
