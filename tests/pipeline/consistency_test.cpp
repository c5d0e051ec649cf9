// What the views say of the model that came of them (Pipeline::check_consistency).
#include <gtest/gtest.h>

#include <memory>

#include "pipeline/runs.h"
#include "plumbline/backend.h"
#include "plumbline/consistency.h"
#include "plumbline/pinhole.h"
#include "plumbline/pipeline.h"
#include "sim/analytic_scene.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

const Pinhole kCamera = test::pinhole(160, 120);

/// What becomes of half an orbit about the desk if its images are taken for those of `claimed`.
ModelConsistency after_run(const Pinhole& claimed, const Parameters& parameters) {
  const sim::AnalyticScene scene = sim::desk_corner();
  const Trajectory path = sim::orbit({.period = 10, .frames = 300});
  const std::shared_ptr<Backend> backend = make_backend("cpu", 2);
  Pipeline pipeline(parameters, claimed, *backend, path.front().world_from_camera);
  for (int i = 0; i < 150; ++i)
    pipeline.process(sim::render(scene, kCamera, path[static_cast<std::size_t>(i)].world_from_camera,
                                 from_seconds(i / 30.0), 5000, false));
  return pipeline.check_consistency();
}

TEST(Consistency, OfAGoodRunItsViewsAgreeWithTheModel) {
  const ModelConsistency found = after_run(kCamera, test::parameters_for_quarter_size());
  EXPECT_GT(found.views, 4);
  EXPECT_GT(found.known, 0.9);
  EXPECT_GT(found.matched, 0.9);
  EXPECT_LT(found.see_through, 0.02);
  EXPECT_LE(found.see_through, found.worst_see_through);
}

TEST(Consistency, AWrongCameraContradictsItself) {
  Pinhole wide = kCamera;
  wide.fx *= 0.7f;
  wide.fy *= 0.7f;
  const ModelConsistency good = after_run(kCamera, test::parameters_for_quarter_size()),
                         wrong = after_run(wide, test::parameters_for_quarter_size());
  EXPECT_LT(wrong.matched, good.matched - 0.1);
  EXPECT_GT(wrong.see_through, 3 * good.see_through);
}

TEST(Consistency, WithoutKeyframesNothingIsCompared) {
  Parameters parameters = test::parameters_for_quarter_size();
  parameters.tracking.relocalise_after = 0;
  EXPECT_EQ(after_run(kCamera, parameters).views, 0);
}

}  // namespace
}  // namespace plumbline
