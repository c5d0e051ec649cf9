#include "run/icp_trace.h"

#include <nlohmann/json.hpp>

#include "kernels/terms.h"

namespace plumbline::app {
namespace {

using Json = nlohmann::ordered_json;

Json iteration_json(const IcpIteration& iteration, const OrientationParameters& orientation, bool damped) {
  const Eigen::Vector3d t = iteration.world_from_camera.translation();
  const Eigen::Quaterniond q = iteration.world_from_camera.quaternion();
  Json json = {{"level", iteration.level},
               {"pairs", iteration.pairs},
               {"matched", iteration.matched},
               {"matched_fraction", iteration.matched_fraction},
               {"median_distance_m", iteration.median_distance},
               {"rms_m", iteration.rms},
               {"step_rotation_rad", {iteration.step[0], iteration.step[1], iteration.step[2]}},
               {"step_translation_m", {iteration.step[3], iteration.step[4], iteration.step[5]}},
               {"world_from_camera", {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}}};
  if (damped) json["lambda"] = kernels::lambda(orientation.schedule, orientation.lambda, iteration.matched_fraction);
  json["histogram"] = iteration.histogram;
  return json;
}

}  // namespace

std::string icp_json(const FrameReport& report, const std::vector<IcpIteration>& iterations,
                     const Parameters& parameters) {
  const bool damped =
      report.orientation == OrientationUse::used && parameters.orientation.term == OrientationTerm::damping;
  Json json = {{"frame", report.index},
               {"status", to_string(report.tracking.status)},
               {"orientation", to_string(report.orientation)},
               {"bin_width_m", iterations.empty() ? 0.0 : iterations.front().bin_width},
               {"iterations", Json::array()}};
  for (const IcpIteration& iteration : iterations)
    json["iterations"].push_back(iteration_json(iteration, parameters.orientation, damped));
  return json.dump(1) + "\n";
}

}  // namespace plumbline::app
