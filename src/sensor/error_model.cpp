#include "sensor/error_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/random.h"
#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/orientation.h"
#include "plumbline/se3.h"
#include "sensor/periodic_error.h"

namespace plumbline {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr const char* kErrorModelWhere = "orientation error model";
constexpr std::uint64_t kHarmonicsStream = 301;

}  // namespace

double PeriodicError::at(double angle) const { return constant + periodic(coefficients.data(), harmonics(), angle); }

SystematicError::SystematicError(const Vector3d& amplitude, int harmonics, std::uint64_t seed) {
  if (harmonics < 1 || harmonics > 100 || !(amplitude.minCoeff() >= 0) || !amplitude.allFinite())
    throw Error("the systematic error is out of range", kErrorModelWhere,
                "give amplitudes from 0 and 1 to 100 harmonics");
  for (int axis = 0; axis < 3; ++axis) {
    Random random(stream(stream(seed, kHarmonicsStream), static_cast<std::uint64_t>(axis)));
    std::vector<double>& coefficients = axes_[static_cast<std::size_t>(axis)].coefficients;
    for (int k = 1; k <= harmonics; ++k) {
      coefficients.push_back(random.normal() / k);
      coefficients.push_back(random.normal() / k);
    }
    constexpr int kGrid = 720;
    double largest = 0;
    for (int i = 0; i < kGrid; ++i)
      largest = std::max(largest, std::abs(about(axis, 2 * std::numbers::pi * i / kGrid)));
    for (double& c : coefficients) c = c * amplitude[axis] / largest;
  }
}

double SystematicError::about(int axis, double angle) const { return axes_[static_cast<std::size_t>(axis)].at(angle); }

Vector3d SystematicError::at(const Matrix3d& earth_from_body) const {
  const Eigen::Quaterniond q(earth_from_body);
  Vector3d error;
  for (int axis = 0; axis < 3; ++axis) {
    const Twist<double> twist = twist_about(q, axis);
    error[axis] = twist.weight * about(axis, twist.angle);
  }
  return error;
}

OrientationErrorModel error_model(std::string_view name) {
  if (name == "ideal") return {};
  if (name == "bno055") return {Vector3d(3, 3, 10) * kRadiansPerDegree};
  throw Error("there is no error model '" + std::string(name) + "'", kErrorModelWhere, "take ideal or bno055");
}

std::vector<OrientationSample> with_error(const OrientationErrorModel& model, std::vector<OrientationSample> samples) {
  const SystematicError error =
      model.measured ? SystematicError(*model.measured) : SystematicError(model.amplitude, model.harmonics, model.seed);
  for (OrientationSample& sample : samples)
    sample.earth_from_body = so3::exp(error.at(sample.earth_from_body)) * sample.earth_from_body;
  return samples;
}

}  // namespace plumbline
