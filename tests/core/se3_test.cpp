#include "plumbline/se3.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace plumbline {
namespace {

constexpr double kPi = 3.14159265358979323846;

class RandomMotions {
 public:
  explicit RandomMotions(unsigned seed) : random_(seed) {}

  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Eigen::Vector3d direction() {
    std::normal_distribution<double> normal;
    return Eigen::Vector3d(normal(random_), normal(random_), normal(random_)).normalized();
  }
  Vector6d tangent(double angle, double length = 2.0) {
    Vector6d xi;
    xi << direction() * angle, direction() * length;
    return xi;
  }
  SE3 motion() { return SE3::exp(tangent(uniform(0, kPi), uniform(0, 5))); }

 private:
  std::mt19937 random_;
};

double difference(const SE3& a, const SE3& b) {
  return (a.rotation() - b.rotation()).norm() + (a.translation() - b.translation()).norm();
}

const std::vector<double> kAngles = {0,       1e-300,     1e-12,      1e-8,       0.99e-4, 1.01e-4, 1e-5,
                                     0.0099,  0.01,       0.0101,     0.0499,     0.05,    0.3,     1.0,
                                     kPi / 2, kPi - 1e-3, kPi - 1e-6, kPi - 1e-9, kPi};

TEST(So3, ExpIsARotationAtEveryAngle) {
  RandomMotions random(1);
  for (const double angle : kAngles) {
    const Eigen::Matrix3d r = so3::exp(random.direction() * angle);
    EXPECT_LT((r * r.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14) << angle;
    EXPECT_NEAR(r.determinant(), 1, 1e-14) << angle;
    EXPECT_NEAR(so3::angle(r), angle, 1e-14 + 1e-15 * angle) << angle;
  }
}

TEST(So3, ExpAgreesWithAngleAxis) {
  RandomMotions random(2);
  for (const double angle : kAngles) {
    const Eigen::Vector3d axis = random.direction();
    EXPECT_LT((so3::exp(axis * angle) - Eigen::AngleAxisd(angle, axis).toRotationMatrix()).norm(), 2e-15) << angle;
  }
}

TEST(So3, LogUndoesExp) {
  RandomMotions random(3);
  for (const double angle : kAngles) {
    const Eigen::Vector3d omega = random.direction() * angle;
    const Eigen::Vector3d back = so3::log(so3::exp(omega));
    // At π itself the axis' sign is free.
    const double error = angle == kPi ? std::min((back - omega).norm(), (back + omega).norm()) : (back - omega).norm();
    EXPECT_LT(error, 1e-14 + 1e-15 * angle) << angle;
  }
}

TEST(So3, LogOfHalfTurnsAboutTheAxesIsExact) {
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Matrix3d r = -Eigen::Matrix3d::Identity();
    r(axis, axis) = 1;
    EXPECT_NEAR(so3::log(r).norm(), kPi, 1e-15);
    EXPECT_NEAR(std::abs(so3::log(r)[axis]), kPi, 1e-15);
  }
}

TEST(So3, LeftJacobianIsTheDerivativeOfExp) {
  RandomMotions random(4);
  for (const double angle : kAngles) {
    if (angle > 3.0) continue;  // central differences would step over π
    const Eigen::Vector3d omega = random.direction() * angle;
    const Eigen::Matrix3d analytic = so3::left_jacobian(omega);
    constexpr double kStep = 1e-5;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d delta = Eigen::Vector3d::Unit(i) * kStep;
      // exp(ω + δ) = exp(J δ) exp(ω)
      const Eigen::Matrix3d forward = so3::exp(omega + delta) * so3::exp(omega).transpose();
      const Eigen::Matrix3d backward = so3::exp(omega - delta) * so3::exp(omega).transpose();
      const Eigen::Vector3d numeric = (so3::log(forward) - so3::log(backward)) / (2 * kStep);
      EXPECT_LT((numeric - analytic.col(i)).norm(), 1e-9) << angle << " column " << i;
    }
  }
}

TEST(So3, LeftJacobianInverseInverts) {
  RandomMotions random(5);
  for (const double angle : kAngles) {
    const Eigen::Vector3d omega = random.direction() * angle;
    const Eigen::Matrix3d product = so3::left_jacobian(omega) * so3::left_jacobian_inverse(omega);
    EXPECT_LT((product - Eigen::Matrix3d::Identity()).norm(), 1e-13) << angle;
  }
}

TEST(Se3, LogUndoesExp) {
  RandomMotions random(6);
  for (const double angle : kAngles) {
    if (angle == kPi) continue;  // the axis' sign is free there; see ExpUndoesLog
    const Vector6d xi = random.tangent(angle);
    EXPECT_LT((SE3::exp(xi).log() - xi).norm(), 1e-13) << angle;
  }
}

TEST(Se3, ExpUndoesLog) {
  RandomMotions random(7);
  for (const double angle : kAngles) {
    const SE3 motion = SE3::exp(random.tangent(angle));
    EXPECT_LT(difference(SE3::exp(motion.log()), motion), 1e-13) << angle;
  }
}

TEST(Se3, ExpIsTheMatrixExponential) {
  RandomMotions random(8);
  for (int i = 0; i < 50; ++i) {
    const Vector6d xi = random.tangent(random.uniform(0, kPi));
    Eigen::Matrix4d generator = Eigen::Matrix4d::Zero();
    generator.topLeftCorner<3, 3>() = hat(xi.head<3>());
    generator.topRightCorner<3, 1>() = xi.tail<3>();
    // Taylor's series of the generator scaled by 2⁻⁸, squared eight times.
    Eigen::Matrix4d term = Eigen::Matrix4d::Identity(), sum = term;
    for (int n = 1; n < 12; ++n) sum += term = term * generator / (256.0 * n);
    for (int n = 0; n < 8; ++n) sum = sum * sum;
    const SE3 motion = SE3::exp(xi);
    EXPECT_LT((sum.topLeftCorner<3, 3>() - motion.rotation()).norm(), 1e-12);
    EXPECT_LT((sum.topRightCorner<3, 1>() - motion.translation()).norm(), 1e-12);
  }
}

TEST(Se3, GroupLaws) {
  RandomMotions random(9);
  for (int i = 0; i < 1000; ++i) {
    const SE3 a = random.motion(), b = random.motion(), c = random.motion();
    const Eigen::Vector3d p = random.direction() * 3;
    EXPECT_LT(difference((a * b) * c, a * (b * c)), 1e-13);
    EXPECT_LT(difference(a * a.inverse(), SE3()), 1e-14);
    EXPECT_LT(difference(a.inverse() * a, SE3()), 1e-14);
    EXPECT_LT(difference(a * SE3(), a), 1e-300);
    EXPECT_LT(((a * b) * p - a * (b * p)).norm(), 1e-13);
    EXPECT_LT(difference((a * b).inverse(), b.inverse() * a.inverse()), 1e-13);
  }
}

TEST(Se3, AdjointMovesATangentThroughAMotion) {
  RandomMotions random(10);
  for (int i = 0; i < 1000; ++i) {
    const SE3 t = random.motion();
    const Vector6d xi = random.tangent(random.uniform(0, 0.1), 0.1);
    EXPECT_LT(difference(t * SE3::exp(xi) * t.inverse(), SE3::exp(t.adjoint() * xi)), 1e-12);
  }
}

TEST(Se3, AdjointIsAHomomorphism) {
  RandomMotions random(11);
  for (int i = 0; i < 100; ++i) {
    const SE3 a = random.motion(), b = random.motion();
    EXPECT_LT(((a * b).adjoint() - a.adjoint() * b.adjoint()).norm(), 1e-12);
    EXPECT_LT((a.adjoint() * a.inverse().adjoint() - Matrix6d::Identity()).norm(), 1e-12);
  }
}

TEST(Se3, LeftPerturbationMovesPointsAsTheTrackerAssumes) {
  // d(exp(ξ) T p)/dξ at 0 = [−hat(T p) | I]: the Jacobian of every residual.
  RandomMotions random(12);
  for (int i = 0; i < 100; ++i) {
    const SE3 t = random.motion();
    const Eigen::Vector3d p = random.direction();
    constexpr double kStep = 1e-6;
    for (int k = 0; k < 6; ++k) {
      const Vector6d xi = Vector6d::Unit(k) * kStep;
      const Eigen::Vector3d numeric = (SE3::exp(xi) * t * p - SE3::exp(-xi) * t * p) / (2 * kStep);
      const Eigen::Vector3d analytic =
          k < 3 ? Eigen::Vector3d(-hat(t * p).col(k)) : Eigen::Vector3d(Eigen::Vector3d::Unit(k - 3));
      EXPECT_LT((numeric - analytic).norm(), 1e-8);
    }
  }
}

TEST(Se3, NormalizedRemovesTheRoundingOfManyProducts) {
  RandomMotions random(13);
  const SE3 step = SE3::exp(random.tangent(0.01, 0.001));
  Eigen::Matrix3d skewed = step.rotation();
  skewed(0, 1) += 1e-6;
  const SE3 repaired = SE3(skewed, step.translation()).normalized();
  EXPECT_LT((repaired.rotation() * repaired.rotation().transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  EXPECT_LT(difference(repaired, step), 2e-6);
}

TEST(Se3, QuaternionsNeedNotBeUnit) {
  const SE3 pose(Eigen::Quaterniond(2, 0, 0, 0), Eigen::Vector3d(1, 2, 3));
  EXPECT_LT((pose.rotation() - Eigen::Matrix3d::Identity()).norm(), 1e-15);
}

TEST(Se3, FiniteIsSeen) {
  EXPECT_TRUE(SE3().is_finite());
  EXPECT_FALSE(SE3(Eigen::Matrix3d(Eigen::Matrix3d::Identity()), Eigen::Vector3d(0, NAN, 0)).is_finite());
}

TEST(Se3, TheKernelsFormMovesPointsAlike) {
  RandomMotions random(14);
  for (int i = 0; i < 100; ++i) {
    const SE3 t = random.motion();
    const Eigen::Vector3d p = random.direction();
    const Vec3<float> q = to_kernel(t).apply(
        Vec3<float>{static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())});
    EXPECT_LT((t * p - Eigen::Vector3d(q.x, q.y, q.z)).norm(), 5e-6);
  }
}

}  // namespace
}  // namespace plumbline
