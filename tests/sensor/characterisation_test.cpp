#include "sensor/characterisation.h"

#include <gtest/gtest.h>

#include "core/random.h"
#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/orientation.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"

namespace plumbline {
namespace {

using Eigen::Vector3d;

/// The paper's rotary table: steps of 5° over a turn about each axis; 6 s each, begin and end told.
std::vector<OrientationSample> table() {
  std::vector<OrientationSample> reference;
  Nanoseconds time = 0;
  for (int axis = 0; axis < 3; ++axis)
    for (int degrees = -175; degrees <= 180; degrees += 5) {
      const Eigen::Matrix3d r = so3::exp(degrees * kRadiansPerDegree * Vector3d::Unit(axis));
      reference.push_back({time, r});
      reference.push_back({time + 6'000'000'000, r});
      time += 8'000'000'000;
    }
  return reference;
}

/// A chip that needs 5 s to settle, read at 10 Hz.
std::vector<OrientationSample> readings_of(const std::vector<OrientationSample>& reference,
                                           const OrientationErrorModel& model, double noise = 0) {
  Random random(99);
  std::vector<OrientationSample> samples;
  for (std::size_t i = 0; i < reference.size(); i += 2)
    for (int k = 0; k < 60; ++k) {
      const Vector3d late(0, 0, k < 50 ? 0.3 : 0);
      samples.push_back({reference[i].time + k * 100'000'000LL, so3::exp(late) * reference[i].earth_from_body});
    }
  samples = with_error(model, samples);
  for (OrientationSample& s : samples)
    s.earth_from_body =
        so3::exp(noise * Vector3d(random.normal(), random.normal(), random.normal())) * s.earth_from_body;
  return samples;
}

TEST(Characterisation, GivesBackTheAmplitudesOfASimulatedChip) {
  const auto reference = table();
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    OrientationErrorModel model = error_model("bno055");
    model.seed = seed;
    const Characterisation study = characterise(reference, readings_of(reference, model));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double put_in = model.amplitude[static_cast<Eigen::Index>(axis)];
      EXPECT_EQ(study.axes[axis].rests.size(), 74U) << "the rests at 0 of the other two axes count, too";
      EXPECT_NEAR(study.axes[axis].amplitude, put_in, 0.05 * put_in) << "axis " << axis << ", seed " << seed;
      EXPECT_LT(study.axes[axis].random, 1e-9);
    }
    EXPECT_TRUE(study.notes.empty());
  }
}

TEST(Characterisation, ItsModelErrsAsTheChip) {
  const auto reference = table();
  OrientationErrorModel model = error_model("bno055");
  model.seed = 4;
  const OrientationErrorModel found = characterise(reference, readings_of(reference, model)).model();
  const auto a = with_error(model, reference), b = with_error(found, reference);
  for (std::size_t i = 0; i < a.size(); ++i)
    EXPECT_LT(so3::angle(a[i].earth_from_body.transpose() * b[i].earth_from_body), 0.02 * kRadiansPerDegree);
}

TEST(Characterisation, RandomPartAndUncertainties) {
  const auto reference = table();
  const double noise = 0.5 * kRadiansPerDegree;
  const Characterisation study =
      characterise(reference, readings_of(reference, {Vector3d(3, 3, 10) * kRadiansPerDegree}, noise));
  for (const AxisStudy& axis : study.axes) EXPECT_NEAR(axis.random, noise, 0.1 * noise);
  const RestReadings rest{0, 10, 3 * kRadiansPerDegree, 4 * kRadiansPerDegree};
  EXPECT_NEAR(rest.combined(), 5 * kRadiansPerDegree, 1e-12);
  EXPECT_NEAR(rest.expanded(), 10 * kRadiansPerDegree, 1e-12);
  for (int axis = 0; axis < 3; ++axis) {
    const double u = study.axes[static_cast<std::size_t>(axis)].combined();
    EXPECT_NEAR(study.covariance()(axis, axis), u * u, 1e-12);
  }
}

TEST(Characterisation, SaysWhatItCannotUse) {
  const auto reference = table();
  EXPECT_THROW(characterise(reference, {}), Error);
  EXPECT_THROW(characterise({reference.front()}, readings_of(reference, {})), Error);
  CharacterisationOptions patient;
  patient.settling = 100;
  EXPECT_THROW(characterise(reference, readings_of(reference, {}), patient), Error);
  auto oblique = reference;
  for (std::size_t i = 0; i < 2; ++i) oblique[i].earth_from_body = so3::exp({1, 1, 0});
  EXPECT_EQ(characterise(oblique, readings_of(reference, {})).notes.size(), 1U);
}

}  // namespace
}  // namespace plumbline
