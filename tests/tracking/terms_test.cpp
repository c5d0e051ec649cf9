// The terms beside the registration, against numerical derivatives and closed forms.
#include "tracking/terms.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "plumbline/angles.h"
#include "plumbline/se3.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

using kernels::NormalEquations;

/// −b is the gradient of the cost under the left increment, and H that of the linearised residual: its own second
/// difference where the residual is small.
template <class Prior>
void expect_derivatives(const Prior& prior, const SE3& pose, const std::function<double(const SE3&)>& cost,
                        double hessian_tolerance) {
  const NormalEquations term = prior.evaluate({pose});
  constexpr double kStep = 1e-4;
  const auto at = [&](const Vector6d& xi) { return cost(SE3::exp(xi) * pose); };
  for (int i = 0; i < 6; ++i) {
    const Vector6d ei = Vector6d::Unit(i) * kStep;
    EXPECT_NEAR(-term.b[i], (at(ei) - at(-ei)) / (2 * kStep), 1e-5 * (1 + term.b.norm())) << i;
    for (int j = 0; j < 6; ++j) {
      const Vector6d ej = Vector6d::Unit(j) * kStep;
      const double second = (at(ei + ej) - at(ei - ej) - at(ej - ei) + at(-ei - ej)) / (4 * kStep * kStep);
      EXPECT_NEAR(term.h(i, j), second, hessian_tolerance * term.h.norm()) << i << ", " << j;
    }
  }
}

TEST(OrientationAnchor, JacobianIsTheNumericalOne) {
  test::Random random(1);
  for (int round = 0; round < 5; ++round) {
    const Eigen::Matrix3d earth_from_world = random.motion(2, 0).rotation();
    const SE3 pose = random.motion(1, 0.5);
    const Eigen::Matrix3d reading =
        random.motion((round == 0 ? 0.001 : 0.6), 0).rotation() * earth_from_world * pose.rotation();
    Eigen::Matrix3d root;
    root << 0.05, 0, 0, 0.01, 0.04, 0, 0.02, -0.01, 0.17;
    const Eigen::Matrix3d covariance = root * root.transpose();
    const auto cost = [&](const SE3& t) {
      const Eigen::Vector3d r = so3::log(earth_from_world * t.rotation() * reading.transpose());
      return 0.5 * r.dot(covariance.inverse() * r);
    };
    const kernels::OrientationAnchor anchor = orientation_anchor(reading, earth_from_world, covariance);
    expect_derivatives(anchor, pose, cost, round == 0 ? 1e-3 : 0.3);
  }
}

TEST(OrientationAnchor, HeadingIsAboutTheVertical) {
  OrientationParameters parameters = preset("kinectfusion").orientation;
  parameters.tilt_sigma = 3;
  parameters.heading_sigma = 10;
  const Eigen::Matrix3d covariance = anchor_covariance(parameters);
  // The world's y axis is the vertical, as for a camera that is held level.
  Eigen::Matrix3d earth_from_world;
  earth_from_world << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  const kernels::OrientationAnchor anchor = orientation_anchor(earth_from_world, earth_from_world, covariance);
  const NormalEquations term = anchor.evaluate({SE3()});
  EXPECT_NEAR(term.h(0, 0), std::pow(3 * kRadiansPerDegree, -2), 1e-9);
  EXPECT_NEAR(term.h(1, 1), std::pow(10 * kRadiansPerDegree, -2), 1e-9);
  EXPECT_NEAR(term.h(2, 2), std::pow(3 * kRadiansPerDegree, -2), 1e-9);
  EXPECT_LT(term.b.norm(), 1e-12);
}

TEST(TiltAnchor, JacobianIsTheNumericalOneAndTheHeadingIsFree) {
  test::Random random(3);
  for (int round = 0; round < 5; ++round) {
    const Eigen::Matrix3d earth_from_world = random.motion(2, 0).rotation();
    const SE3 pose = random.motion(1, 0.5);
    const Eigen::Matrix3d reading =
        random.motion((round == 0 ? 0.001 : 0.4), 0).rotation() * earth_from_world * pose.rotation();
    Eigen::Matrix3d covariance = Eigen::Vector3d(0.01, 0.02, 1).asDiagonal();
    covariance(0, 1) = covariance(1, 0) = 0.005;
    const Eigen::Matrix2d information = covariance.topLeftCorner<2, 2>().inverse();
    const auto cost = [&](const SE3& t) {
      const Eigen::Vector3d up = earth_from_world * t.rotation() * reading.transpose().col(2);
      const Eigen::Vector2d r(-up.y(), up.x());
      return 0.5 * r.dot(information * r);
    };
    const kernels::TiltAnchor anchor = tilt_anchor(reading, earth_from_world, covariance);
    expect_derivatives(anchor, pose, cost, round == 0 ? 1e-3 : 0.3);
    // Neither the reading's heading nor the camera's matters.
    const Eigen::Matrix3d about_up = so3::exp({0, 0, 2});
    const kernels::TiltAnchor turned = tilt_anchor(about_up * reading, earth_from_world, covariance);
    EXPECT_LT((turned.evaluate({pose}).b - anchor.evaluate({pose}).b).norm(), 1e-9);
    Vector6d heading = Vector6d::Zero();
    heading.head<3>() = earth_from_world.row(2);
    if (round == 0) {
      EXPECT_LT((anchor.evaluate({pose}).h * heading).norm(), 1e-3 * anchor.evaluate({pose}).h.norm());
    }
  }
}

TEST(TranslationPrior, JacobianIsTheNumericalOne) {
  const SE3 pose = test::Random(2).motion(1, 1);
  const Eigen::Vector3d previous = pose.translation() + Eigen::Vector3d(0.02, -0.01, 0.03);
  Eigen::Matrix3d root;
  root << 0.02, 0, 0, 0.01, 0.03, 0, 0, -0.01, 0.025;
  const Eigen::Matrix3d covariance = root * root.transpose();
  const kernels::TranslationPrior prior = translation_prior(previous, covariance);
  // Gauss-Newton leaves out the residual's own curvature, which is that of a rotation over these few centimetres.
  expect_derivatives(
      prior, pose,
      [&](const SE3& t) {
        const Eigen::Vector3d r = t.translation() - previous;
        return 0.5 * r.dot(covariance.inverse() * r);
      },
      0.1);
}

TEST(RotationDamping, IsThePapersTerm) {
  // 2 λ n PᵀP with the schedules of the matched fraction.
  const struct {
    LambdaSchedule schedule;
    double expected;
  } table[] = {{LambdaSchedule::constant, 0.2},
               {LambdaSchedule::inverse_sqrt, 0.2 / 0.5},
               {LambdaSchedule::inverse, 0.2 / 0.25},
               {LambdaSchedule::inverse_square, 0.2 / 0.0625},
               {LambdaSchedule::negative_log, -0.2 * std::log(0.25)}};
  for (const auto& row : table) {
    EXPECT_DOUBLE_EQ(kernels::lambda(row.schedule, 0.2, 0.25), row.expected);
    EXPECT_EQ(kernels::lambda(row.schedule, 0.2, 0), 0) << "nothing matched, nothing to damp";
    const NormalEquations term = kernels::RotationDamping{row.schedule, 0.2}.evaluate({SE3(), {250, 1000, 0.5}});
    Matrix6d expected = Matrix6d::Zero();
    expected.diagonal().head<3>().setConstant(0.5 * 2 * row.expected * 250);
    EXPECT_LT((term.h - expected).norm(), 1e-12);
    EXPECT_EQ(term.b, Vector6d::Zero());
  }
}

TEST(RegistrationInformation, IsThatOfAnImageAtEverySize) {
  TrackingParameters parameters = preset("kinectfusion").tracking;
  parameters.redundancy = 100;
  EXPECT_EQ(registration_information(parameters, 320 * 240), 1 / (100 * 0.007 * 0.007));
  // Twice as fine: four times the pixels with a quarter of the say each.
  EXPECT_EQ(registration_information(parameters, 640 * 480), 1 / (400 * 0.007 * 0.007));
  parameters.redundancy = 1;
  EXPECT_EQ(registration_information(parameters, 80 * 60), 1 / (0.007 * 0.007)) << "never more than one pixel's";
}

TEST(PosePrior, JacobianIsTheNumericalOne) {
  test::Random random(6);
  for (int round = 0; round < 5; ++round) {
    const SE3 pose = random.motion(1, 1), expected = random.motion(round == 0 ? 0.001 : 0.5, 0.01) * pose;
    Matrix6d root = Matrix6d(Vector6d(0.05, 0.04, 0.17, 0.02, 0.03, 0.025).asDiagonal());
    root(1, 0) = 0.02;
    root(3, 1) = 0.01;  // rotation and position are correlated in a filter
    root(5, 2) = -0.02;
    const Matrix6d information = (root * root.transpose()).inverse();
    const auto cost = [&](const SE3& t) {
      Vector6d r;
      r << so3::log(t.rotation() * expected.rotation().transpose()), t.translation() - expected.translation();
      return 0.5 * r.dot(information * r);
    };
    expect_derivatives(kernels::PosePrior{expected, information}, pose, cost, round == 0 ? 0.02 : 0.6);
  }
}

TEST(PosePrior, WithoutCorrelationIsAnAnchorAndATranslationPrior) {
  test::Random random(7);
  const SE3 pose = random.motion(1, 1), expected = random.motion(0.3, 0.1) * pose;
  const Eigen::Matrix3d unit = Eigen::Matrix3d::Identity();
  Matrix6d information = Matrix6d::Zero();
  information.topLeftCorner<3, 3>() = 30 * unit;
  information.bottomRightCorner<3, 3>() = 50 * unit;
  kernels::Terms parts;
  parts.set(kernels::OrientationAnchor{expected.rotation(), unit, 30 * unit});
  parts.set(kernels::TranslationPrior{expected.translation(), 50 * unit});
  const NormalEquations whole = kernels::PosePrior{expected, information}.evaluate({pose}),
                        sum = parts.evaluate({pose});
  EXPECT_LT((whole.h - sum.h).norm(), 1e-9 * sum.h.norm());
  EXPECT_LT((whole.b - sum.b).norm(), 1e-9 * sum.b.norm());
}

TEST(Terms, AddUpInTheOrderOfTheirKinds) {
  test::Random random(4);
  const kernels::Estimate at = {random.motion(1, 1), {250, 1000, 0.5}};
  const kernels::RotationDamping damping{LambdaSchedule::constant, 2};
  const kernels::OrientationAnchor anchor = orientation_anchor(
      random.motion(1, 0).rotation(), random.motion(1, 0).rotation(), 0.01 * Eigen::Matrix3d::Identity());
  const kernels::TranslationPrior position = translation_prior({1, 0, 0}, 0.04 * Eigen::Matrix3d::Identity());
  kernels::Terms terms;
  EXPECT_TRUE(terms.empty());
  EXPECT_EQ(terms.evaluate(at).h, Matrix6d::Zero());
  terms.set(position);
  EXPECT_FALSE(terms.empty());
  ASSERT_NE(terms.find<kernels::TranslationPrior>(), nullptr);
  EXPECT_EQ(terms.find<kernels::PosePrior>(), nullptr);
  terms.set(anchor);
  terms.set(damping);
  const NormalEquations sum = terms.evaluate(at), a = anchor.evaluate(at), p = position.evaluate(at);
  EXPECT_LT((sum.h - damping.evaluate(at).h - a.h - p.h).norm(), 1e-9 * sum.h.norm());
  EXPECT_LT((sum.b - a.b - p.b).norm(), 1e-9 * sum.b.norm());
  kernels::Terms other_order;
  other_order.set(damping);
  other_order.set(anchor);
  other_order.set(position);
  EXPECT_EQ(other_order.evaluate(at).h, sum.h);
  EXPECT_EQ(other_order.evaluate(at).b, sum.b);
}

}  // namespace
}  // namespace plumbline
