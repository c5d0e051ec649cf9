#include "sensor/characterisation.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "plumbline/error.h"
#include "plumbline/orientation.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"

namespace plumbline {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr const char* kCharacterisationWhere = "characterisation";

double square(double x) { return x * x; }

/// A time during which the reference does not move.
struct Rest {
  Nanoseconds begin = 0, end = 0;
  Matrix3d earth_from_body;
};

std::vector<Rest> rests_of(const std::vector<OrientationSample>& reference, double still) {
  std::vector<Rest> rests;
  for (std::size_t first = 0; first < reference.size();) {
    std::size_t last = first;
    const Matrix3d& there = reference[first].earth_from_body;
    while (last + 1 < reference.size() && so3::angle(there.transpose() * reference[last + 1].earth_from_body) < still)
      ++last;
    if (last > first) rests.push_back({reference[first].time, reference[last].time, there});
    first = last + 1;
  }
  return rests;
}

/// Rotation vectors from reference to reading, earth axes, of the readings of a rest once it has settled.
std::vector<Vector3d> errors_in(const Rest& rest, const std::vector<OrientationSample>& readings, double settling) {
  std::vector<Vector3d> errors;
  const auto by_time = [](const OrientationSample& s, Nanoseconds t) { return s.time < t; };
  auto at = std::lower_bound(readings.begin(), readings.end(), rest.begin + from_seconds(settling), by_time);
  for (; at != readings.end() && at->time <= rest.end; ++at)
    errors.push_back(so3::log(at->earth_from_body * rest.earth_from_body.transpose()));
  return errors;
}

/// The angle about an earth axis, if the rest is turned about nothing else.
std::optional<double> angle_about(int axis, const Matrix3d& earth_from_body, double off_axis) {
  const Eigen::Quaterniond q(earth_from_body);
  const double along = q.vec()[axis], twist = std::hypot(along, q.w());
  if (2 * std::acos(std::min(1.0, twist)) > off_axis) return std::nullopt;
  return std::remainder(2 * std::atan2(along, q.w()), 2 * std::numbers::pi);
}

RestReadings summary_of(const std::vector<Vector3d>& errors, int axis, double angle) {
  RestReadings rest;
  rest.angle = angle;
  rest.count = errors.size();
  const auto n = static_cast<double>(errors.size());
  for (const Vector3d& e : errors) rest.systematic += e[axis] / n;
  double sum = 0;
  for (const Vector3d& e : errors) sum += square(e[axis] - rest.systematic);
  if (errors.size() > 1) rest.random = std::sqrt(sum / (n - 1));
  return rest;
}

/// Least squares over the rests; as many harmonics as their number allows, half of it.
PeriodicError fitted(const std::vector<RestReadings>& rests, int harmonics) {
  const auto n = static_cast<Eigen::Index>(rests.size());
  const Eigen::Index order = std::min<Eigen::Index>(harmonics, n / 4);
  Eigen::MatrixXd basis(n, 1 + 2 * order);
  Eigen::VectorXd values(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const RestReadings& rest = rests[static_cast<std::size_t>(i)];
    values[i] = rest.systematic;
    basis(i, 0) = 1;
    for (Eigen::Index k = 1; k <= order; ++k) {
      basis(i, 2 * k - 1) = std::sin(static_cast<double>(k) * rest.angle);
      basis(i, 2 * k) = std::cos(static_cast<double>(k) * rest.angle);
    }
  }
  // The shortest solution where the angles do not tell the harmonics apart.
  const Eigen::VectorXd found = basis.completeOrthogonalDecomposition().solve(values);
  PeriodicError fit;
  fit.constant = found[0];
  for (Eigen::Index k = 1; k <= order; ++k)
    fit.coefficients.insert(fit.coefficients.end(), {found[2 * k - 1], found[2 * k]});
  return fit;
}

void summarise(const CharacterisationOptions& options, AxisStudy* study) {
  if (study->rests.empty()) return;
  std::sort(study->rests.begin(), study->rests.end(),
            [](const RestReadings& a, const RestReadings& b) { return a.angle < b.angle; });
  const auto n = static_cast<double>(study->rests.size());
  double systematic = 0, random = 0;
  for (const RestReadings& rest : study->rests) {
    study->amplitude = std::max(study->amplitude, std::abs(rest.systematic));
    systematic += square(rest.systematic) / n;
    random += square(rest.random) / n;
  }
  study->systematic = std::sqrt(systematic);
  study->random = std::sqrt(random);
  study->fit = fitted(study->rests, options.harmonics);
}

}  // namespace

double RestReadings::combined() const { return std::hypot(systematic, random); }
double AxisStudy::combined() const { return std::hypot(systematic, random); }

Eigen::Matrix3d Characterisation::covariance() const {
  Vector3d variance;
  for (int axis = 0; axis < 3; ++axis) {
    const auto of = [&](int i) { return square(axes[static_cast<std::size_t>(i)].combined()); };
    const auto turned = [&](int i) { return !axes[static_cast<std::size_t>(i)].rests.empty(); };
    const int other = axis < 2 ? 1 - axis : 2;
    variance[axis] = turned(axis) ? of(axis) : turned(other) ? of(other) : std::max({of(0), of(1), of(2)});
    variance[axis] = std::max(variance[axis], square(0.01 * std::numbers::pi / 180));  // nothing is exact
  }
  return variance.asDiagonal();
}

OrientationErrorModel Characterisation::model() const {
  OrientationErrorModel model;
  model.measured.emplace();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    model.amplitude[static_cast<Eigen::Index>(axis)] = axes[axis].amplitude;
    (*model.measured)[axis] = axes[axis].fit;
  }
  return model;
}

Characterisation characterise(const std::vector<OrientationSample>& reference,
                              const std::vector<OrientationSample>& readings, const CharacterisationOptions& options) {
  Characterisation study;
  std::size_t used = 0, empty = 0, oblique = 0;
  for (const Rest& rest : rests_of(reference, options.still)) {
    const std::vector<Vector3d> errors = errors_in(rest, readings, options.settling);
    if (errors.size() < options.fewest_readings) {
      ++empty;
      continue;
    }
    bool belongs = false;
    for (int axis = 0; axis < 3; ++axis)
      if (const auto angle = angle_about(axis, rest.earth_from_body, options.off_axis)) {
        study.axes[static_cast<std::size_t>(axis)].rests.push_back(summary_of(errors, axis, *angle));
        belongs = true;
      }
    belongs ? ++used : ++oblique;
  }
  if (used == 0)
    throw Error("no rest of the reference has readings of the sensor", kCharacterisationWhere,
                "give two stamps or more of each rest, on the sensor's clock, that last longer than the settling time");
  if (empty > 0) study.notes.push_back(fmt::format("{} rests have too few readings and were left out", empty));
  if (oblique > 0)
    study.notes.push_back(fmt::format("{} rests are turned about more than one axis and were left out", oblique));
  for (AxisStudy& axis : study.axes) summarise(options, &axis);
  return study;
}

}  // namespace plumbline
