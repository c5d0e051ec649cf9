#include "imu/error_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/random.h"
#include "imu/periodic_error.h"

namespace plumbline {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr const char* kWhere = "orientation error model";
constexpr double kPi = std::numbers::pi;
constexpr std::uint64_t kHarmonicsStream = 301;

}  // namespace

SystematicError::SystematicError(const Vector3d& amplitude, int harmonics, std::uint64_t seed) : harmonics_(harmonics) {
  if (harmonics < 1 || harmonics > 100 || !(amplitude.minCoeff() >= 0) || !amplitude.allFinite())
    throw Error("the systematic error is out of range", kWhere, "give amplitudes from 0 and 1 to 100 harmonics");
  for (int axis = 0; axis < 3; ++axis) {
    Random random(stream(stream(seed, kHarmonicsStream), static_cast<std::uint64_t>(axis)));
    for (int k = 1; k <= harmonics; ++k) {
      coefficients_.push_back(random.normal() / k);
      coefficients_.push_back(random.normal() / k);
    }
    constexpr int kGrid = 720;
    double largest = 0;
    for (int i = 0; i < kGrid; ++i) largest = std::max(largest, std::abs(about(axis, 2 * kPi * i / kGrid)));
    for (auto c = coefficients_.end() - 2 * harmonics; c != coefficients_.end(); ++c)
      *c = *c * amplitude[axis] / largest;
  }
}

double SystematicError::about(int axis, double angle) const {
  return periodic(coefficients_.data() + 2 * harmonics_ * axis, harmonics_, angle);
}

Vector3d SystematicError::at(const Matrix3d& earth_from_body) const {
  return periodic_error(coefficients_.data(), harmonics_, Eigen::Quaterniond(earth_from_body));
}

OrientationErrorModel error_model(std::string_view name) {
  constexpr double kDegree = kPi / 180;
  if (name == "ideal") return {};
  if (name == "bno055") return {Vector3d(3, 3, 10) * kDegree};
  throw Error("there is no error model '" + std::string(name) + "'", kWhere, "take ideal or bno055");
}

std::vector<OrientationSample> with_error(const OrientationErrorModel& model, std::vector<OrientationSample> samples) {
  const SystematicError error(model.amplitude, model.harmonics, model.seed);
  for (OrientationSample& sample : samples)
    sample.earth_from_body = so3::exp(error.at(sample.earth_from_body)) * sample.earth_from_body;
  return samples;
}

}  // namespace plumbline
