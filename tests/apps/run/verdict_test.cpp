// What a run says of itself where the truth is not known.
#include "run/verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace plumbline {
namespace {

using app::Verdict;
using testing::HasSubstr;
using testing::Not;

app::Reconstruction tracked_run(int frames) {
  app::Reconstruction run;
  for (int i = 0; i < frames; ++i) {
    FrameReport frame;
    frame.index = i;
    frame.tracking.status = i == 0 ? TrackingStatus::initialised : TrackingStatus::tracked;
    frame.tracking.rank = 6;
    frame.tracking.iterations = {4, 4, 4};
    frame.tracking.condition = 80;
    frame.tracking.median_distance = 0.004;
    frame.tracking.pairs = 1000;
    frame.tracking.inliers = 900;
    frame.tracking.inlier_fraction = 0.8;
    run.frames.push_back(frame);
    run.trajectory.push_back({frame.time, SE3()});
  }
  run.consistency = {20, 0.95, 0.9, 0.005, 0.01};
  return run;
}

TEST(Verdict, NothingSpeaksAgainstAGoodRun) {
  const Verdict verdict = app::verdict_of(tracked_run(100));
  EXPECT_EQ(verdict.level, Verdict::Level::good);
  EXPECT_EQ(verdict.text, "All 100 frames were tracked.");
  for (const app::Doubt& doubt : verdict.doubts) EXPECT_LT(doubt.weight(), 1) << doubt.name;
}

TEST(Verdict, AModelThatItsViewsSeeThroughIsNotCalledGood) {
  app::Reconstruction run = tracked_run(100);
  run.consistency.see_through = 0.3;
  const Verdict verdict = app::verdict_of(run);
  EXPECT_EQ(verdict.level, Verdict::Level::poor);
  EXPECT_THAT(verdict.text, HasSubstr("The model contradicts the views that it was made of"));
  EXPECT_GT(verdict.doubt, app::verdict_of(tracked_run(100)).doubt);
}

TEST(Verdict, TheTruthDecidesWhereItIsKnown) {
  app::Reconstruction run = tracked_run(100);
  run.consistency.see_through = 0.3;
  run.ate.emplace();
  run.ate->translation.rmse = 0.01;
  EXPECT_EQ(app::verdict_of(run).level, Verdict::Level::good);
  EXPECT_THAT(app::verdict_of(run).text, Not(HasSubstr("contradicts")));
  run.ate->translation.rmse = 0.5;
  EXPECT_EQ(app::verdict_of(run).level, Verdict::Level::poor);
}

TEST(Verdict, AViewThatLeavesADirectionOpenIsSaid) {
  app::Reconstruction run = tracked_run(100);
  for (std::size_t i = 40; i < 70; ++i) run.frames[i].tracking.rank = 5;
  const Verdict verdict = app::verdict_of(run);
  EXPECT_EQ(verdict.level, Verdict::Level::poor);
  EXPECT_THAT(verdict.text, HasSubstr("left a direction nearly open"));
}

TEST(Verdict, FramesThatDoNotFitTheModelAreSaid) {
  app::Reconstruction run = tracked_run(100);
  for (FrameReport& frame : run.frames) frame.tracking.median_distance = 0.03;
  EXPECT_EQ(app::verdict_of(run).level, Verdict::Level::poor);
  EXPECT_THAT(app::verdict_of(run).text, HasSubstr("from the model (median)"));
  run = tracked_run(100);
  for (FrameReport& frame : run.frames) frame.tracking.inliers = 10;
  EXPECT_NE(app::verdict_of(run).level, Verdict::Level::good);
}

TEST(Verdict, SmallImagesAreNotJudgedByTheDistancesOfLargeOnes) {
  app::Reconstruction run = tracked_run(100);
  for (FrameReport& frame : run.frames) {  // as a right run has them at 160x120
    frame.tracking.median_distance = 0.0213;
    frame.tracking.inlier_fraction = 0.552;
    frame.tracking.inliers = 645;
  }
  run.sequence.camera = {525, 525, 319.5f, 239.5f, 640, 480};
  EXPECT_NE(app::verdict_of(run).level, Verdict::Level::good);
  run.sequence.camera = {131.25f, 131.25f, 79.5f, 59.5f, 160, 120};
  EXPECT_EQ(app::verdict_of(run).level, Verdict::Level::good);
  for (FrameReport& frame : run.frames) frame.tracking.median_distance = 0.05;
  EXPECT_EQ(app::verdict_of(run).level, Verdict::Level::poor);
  EXPECT_THAT(app::verdict_of(run).text, HasSubstr("lie 50.0")) << "as measured";
}

TEST(Verdict, WarningsOfTheInputAndTheSensorAreWeighed) {
  app::Reconstruction run = tracked_run(100);
  run.sequence.warnings.push_back({"the depth scale is perhaps 1000", "give --depth-scale 1000"});
  EXPECT_EQ(app::verdict_of(run).level, Verdict::Level::fair);
  EXPECT_THAT(app::verdict_of(run).text, HasSubstr("the depth scale is perhaps 1000"));
  app::Reconstruction late = tracked_run(100);
  late.orientation_message = "The sensor's clock seems to be late.";
  EXPECT_EQ(app::verdict_of(late).level, Verdict::Level::fair);
  EXPECT_THAT(app::verdict_of(late).text, HasSubstr(late.orientation_message));
}

TEST(Verdict, WithoutKeyframesTheModelIsNotWeighed) {
  app::Reconstruction run = tracked_run(100);
  run.consistency = {};
  EXPECT_EQ(app::verdict_of(run).level, Verdict::Level::good);
  EXPECT_THAT(app::verdict_of(run).text, Not(HasSubstr("model")));
}

TEST(Doubt, GrowsSteadilyWithItsValue) {
  const auto weight = [](double value) { return app::Doubt{"", value, 0.1, 0.5, ""}.weight(); };
  EXPECT_DOUBLE_EQ(weight(0), 0);
  EXPECT_DOUBLE_EQ(weight(0.05), 0.5);
  EXPECT_DOUBLE_EQ(weight(0.1), 1);
  EXPECT_DOUBLE_EQ(weight(0.5), 2);
  EXPECT_DOUBLE_EQ(weight(100), 4);
}

}  // namespace
}  // namespace plumbline
