// A frame to register whose motion is known, and the kinds of registration, for the tests of the backends.
#pragma once

#include <cmath>
#include <functional>
#include <list>
#include <vector>

#include "backend/maps.h"
#include "kernels/registration.h"
#include "plumbline/angles.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "support/scenes.h"

namespace plumbline::test {

/// The desk from two poses some 2 cm and 1.5° apart, on three levels, and what the registration may look for.
class RegistrationProblem {
 public:
  RegistrationProblem(const Backend& backend, bool median_filter, const Pinhole& finest = pinhole(160, 120)) {
    static const sim::AnalyticScene scene = sim::desk_corner();
    registration.world_from_model = sim::orbit().front().world_from_camera;
    truth = Random(5).motion(1.5 * kRadiansPerDegree, 0.02);
    for (int level = 2; level >= 0; --level) {
      const Pinhole camera = finest.level(level);
      const auto seen = [&](const SE3& pose) { return to_level(backend, camera, view_of(scene, camera, pose)); };
      images_.push_back({seen(registration.world_from_model * truth), seen(registration.world_from_model)});
      kernels::RegistrationLevel& out = registration.levels[registration.level_count++];
      out.images = icp_input(images_.back().live, images_.back().model);
      if (median_filter) out.distances = images_.back().live.pair_distances.view();
      out.pixels = camera.width * camera.height;
      out.iterations = 3;
      out.min_inliers = 6;
    }
    kernels::RegistrationRules& rules = registration.rules;
    rules.distance_gate = 0.1;
    rules.widest_gate = 0.3;
    rules.cos_normal_gate = static_cast<float>(std::cos(20 * kRadiansPerDegree));
    rules.bins = 500;
    rules.bins_per_metre = 1000;
    rules.median_filter = rules.every_distribution = median_filter;
    rules.median_band = 0.05;
    rules.max_condition = 1e6;
    rules.max_iterations = 10;
  }

  kernels::Registration registration;
  SE3 truth;  ///< model_from_live

 private:
  struct Images {
    DepthLevel live, model;
  };
  std::list<Images> images_;
};

/// What a registration may be asked to do.
struct RegistrationVariant {
  const char* name;
  bool median_filter;
  std::function<void(kernels::Registration*)> change;
};

inline std::vector<RegistrationVariant> registration_variants() {
  return {
      {"plain", false, [](kernels::Registration*) {}},
      {"median filter", true, [](kernels::Registration*) {}},
      {"median stands still", true, [](kernels::Registration* r) { r->rules.converged_after = 2; }},
      {"small step", false, [](kernels::Registration* r) { r->rules.converged_step = 5e-4; }},
      {"gate follows the median", false,
       [](kernels::Registration* r) {
         r->rules.gate_per_median = 5;
         r->rules.every_distribution = true;
       }},
      {"anchor and position", false,
       [](kernels::Registration* r) {
         const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
         r->terms.set(kernels::OrientationAnchor{r->world_from_model.rotation(), unit, 20 * unit});
         r->terms.set(kernels::TranslationPrior{r->world_from_model.translation(), 20 * unit});
       }},
      {"tilt", false,
       [](kernels::Registration* r) {
         r->terms.set(kernels::TiltAnchor{r->world_from_model.rotation().row(2), Eigen::Matrix3d::Identity(),
                                          Eigen::Vector3d(20, 20, 0).asDiagonal()});
       }},
      {"pose", false,
       [](kernels::Registration* r) {
         r->terms.set(kernels::PosePrior{r->world_from_model, 20 * Matrix6d::Identity()});
       }},
      {"damping", false,
       [](kernels::Registration* r) {
         r->terms.set(kernels::RotationDamping{LambdaSchedule::inverse_sqrt, 0.05});
       }},
      {"nothing matches", false, [](kernels::Registration* r) { r->rules.distance_gate = 1e-9; }},
      {"no level", false, [](kernels::Registration* r) { r->level_count = 0; }},
  };
}

}  // namespace plumbline::test
