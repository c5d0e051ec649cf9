#include "eval/orientation_error.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "plumbline/error.h"
#include "plumbline/orientation.h"

namespace plumbline::eval {

OrientationError orientation_error(const std::vector<OrientationSample>& reference,
                                   const std::vector<OrientationSample>& estimate, Nanoseconds tolerance) {
  const auto square = [](double x) { return x * x; };
  OrientationError sum;
  std::size_t at = 0;
  for (const OrientationSample& truth : reference) {
    const auto distance = [&](std::size_t i) { return std::abs(estimate[i].time - truth.time); };
    while (at + 1 < estimate.size() && distance(at + 1) <= distance(at)) ++at;
    if (estimate.empty() || distance(at) > tolerance) continue;
    const Eigen::Quaterniond error(estimate[at].earth_from_body * truth.earth_from_body.transpose());
    const double about_up = std::hypot(error.w(), error.z()), across = std::hypot(error.x(), error.y());
    sum.total += square(2 * std::atan2(error.vec().norm(), std::abs(error.w())));
    sum.heading += square(2 * std::atan2(std::abs(error.z()), std::abs(error.w())));
    sum.inclination += square(2 * std::atan2(across, about_up));
    ++sum.count;
  }
  if (sum.count == 0)
    throw Error("no stamps of reference and estimate agree", "orientation error",
                "check that both are of one recording");
  const auto root = [&](double x) { return std::sqrt(x / static_cast<double>(sum.count)); };
  return {root(sum.total), root(sum.heading), root(sum.inclination), sum.count};
}

}  // namespace plumbline::eval
