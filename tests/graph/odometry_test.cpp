// Motions along the path and how well they are known.
#include "graph/odometry.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace plumbline {
namespace {

SE3 draw(Random* random, double rotation, double translation) {
  Vector6d v;
  for (int i = 0; i < 6; ++i) v[i] = (i < 3 ? rotation : translation) * random->normal();
  return SE3::exp(v);
}

std::vector<PathView> views(std::size_t count) {
  Random random(5);
  std::vector<PathView> list(count);
  for (std::size_t i = 1; i < count; ++i)
    list[i].world_from_camera = list[i - 1].world_from_camera * draw(&random, 0.2, 0.3);
  return list;
}

std::vector<std::optional<ViewEdge>> neighbours(const std::vector<PathView>& list) {
  std::vector<std::optional<ViewEdge>> edges;
  for (std::size_t i = 0; i + 1 < list.size(); ++i) {
    ViewEdge edge;
    edge.first = i;
    edge.second = i + 1;
    edge.motion.first_from_second = list[i].world_from_camera.inverse() * list[i + 1].world_from_camera;
    edge.motion.covariance = 1e-4 * Matrix6d::Identity();
    edge.motion.covariance(3, 3) = 4e-4;
    edges.push_back(edge);
  }
  return edges;
}

TEST(Odometry, BetweenTwoViewsIsTheProductOfTheSteps) {
  const std::vector<PathView> list = views(8);
  const Odometry odometry(list, neighbours(list), 0.5);
  RelativePose product = odometry.steps()[2];
  for (std::size_t i = 3; i < 6; ++i) product = compose(product, odometry.steps()[i]);
  const RelativePose between = odometry.between(2, 6);
  EXPECT_LT(pose_difference(between.first_from_second, product.first_from_second).norm(), 1e-12);
  EXPECT_LT((between.covariance - product.covariance).norm(), 1e-12 + 1e-9 * product.covariance.norm());
  const RelativePose back = inverse(odometry.between(6, 2));
  EXPECT_LT((between.covariance - back.covariance).norm(), 1e-9 * product.covariance.norm());
}

TEST(Odometry, CovarianceOfAProductIsThatOfItsSamples) {
  Random random(11);
  const RelativePose a{draw(&random, 1, 1), 1e-6 * Matrix6d::Identity()},
      b{draw(&random, 1, 1), 4e-6 * Matrix6d::Identity()};
  const RelativePose ab = compose(a, b), back = inverse(ab);
  const auto disturbed = [&](const RelativePose& motion, double sigma) {
    const SE3& z = motion.first_from_second;
    Vector6d v;
    for (int i = 0; i < 6; ++i) v[i] = sigma * random.normal();
    return SE3(so3::exp(Eigen::Vector3d(v.head<3>())) * z.rotation(), z.translation() + v.tail<3>());
  };
  Matrix6d sampled = Matrix6d::Zero(), sampled_back = Matrix6d::Zero();
  constexpr int kSamples = 20000;
  for (int i = 0; i < kSamples; ++i) {
    const SE3 product = disturbed(a, 1e-3) * disturbed(b, 2e-3);
    const Vector6d d = pose_difference(product, ab.first_from_second),
                   e = pose_difference(product.inverse(), back.first_from_second);
    sampled += d * d.transpose() / kSamples;
    sampled_back += e * e.transpose() / kSamples;
  }
  EXPECT_LT((sampled - ab.covariance).norm(), 0.05 * ab.covariance.norm());
  EXPECT_LT((sampled_back - back.covariance).norm(), 0.05 * back.covariance.norm());
}

TEST(Odometry, KnowsLittleWhereRegistrationDisagreesAndAcrossACut) {
  std::vector<PathView> list = views(4);
  std::vector<std::optional<ViewEdge>> edges = neighbours(list);
  edges[1]->motion.first_from_second =
      SE3(edges[1]->motion.first_from_second.rotation(),
          edges[1]->motion.first_from_second.translation() + Eigen::Vector3d(0.2, 0, 0));
  for (std::size_t i = 3; i < list.size(); ++i) list[i].piece = 1;
  const Odometry odometry(list, edges, 1);
  EXPECT_NEAR(odometry.steps()[0].covariance(3, 3), 4e-4, 1e-6);
  EXPECT_NEAR(odometry.steps()[1].covariance(3, 3), 0.04, 0.001);
  EXPECT_GT(odometry.steps()[2].covariance(3, 3), 0.002);
}

}  // namespace
}  // namespace plumbline
