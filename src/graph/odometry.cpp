#include "graph/odometry.h"

#include <algorithm>

#include "plumbline/angles.h"

namespace plumbline {
namespace {

Matrix6d isotropic(double rotation, double translation) {
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(rotation * rotation), Eigen::Vector3d::Constant(translation * translation);
  return variance.asDiagonal();
}

/// By (θ, t) of the first and of the second factor of a product.
struct ProductJacobians {
  Matrix6d first = Matrix6d::Identity(), second = Matrix6d::Zero();

  ProductJacobians(const SE3& a, const SE3& b) {
    first.bottomLeftCorner<3, 3>() = -hat(a.rotation() * b.translation());
    second.topLeftCorner<3, 3>() = second.bottomRightCorner<3, 3>() = a.rotation();
  }
};

// What could not be registered anew is right to this.
constexpr double kGuessRotation = radians(1.5), kGuessTranslation = 0.05;  // metres
// Where a place was recognised after an interruption the path goes on in the map as it was there, whatever it drifted
// by since.
constexpr double kCutRotation = radians(5), kCutTranslation = 0.5;  // metres

Matrix6d step_covariance(const SE3& tracked, const std::optional<ViewEdge>& edge, bool is_cut, double scale) {
  if (is_cut) return isotropic(kCutRotation, kCutTranslation);
  if (!edge) return isotropic(kGuessRotation, kGuessTranslation);
  const Vector6d d = pose_difference(edge->motion.first_from_second, tracked);
  return scale * edge->motion.covariance + d * d.transpose() + isotropic(1e-4, 1e-4);
}

}  // namespace

RelativePose compose(const RelativePose& a_from_b, const RelativePose& b_from_c) {
  const SE3 &a = a_from_b.first_from_second, &b = b_from_c.first_from_second;
  const ProductJacobians j(a, b);
  return {a * b,
          j.first * a_from_b.covariance * j.first.transpose() + j.second * b_from_c.covariance * j.second.transpose()};
}

Odometry::Odometry(const std::vector<PathView>& views, const std::vector<std::optional<ViewEdge>>& neighbours,
                   double scale) {
  from_start_.push_back({SE3(), Matrix6d::Zero()});
  for (std::size_t i = 0; i + 1 < views.size(); ++i) {
    const SE3 tracked = views[i].world_from_camera.inverse() * views[i + 1].world_from_camera;
    steps_.push_back({tracked, step_covariance(tracked, neighbours[i], views[i].piece != views[i + 1].piece, scale)});
    from_start_.push_back(compose(from_start_.back(), steps_.back()));
  }
}

RelativePose Odometry::between(std::size_t first, std::size_t second) const {
  if (first > second) return inverse(between(second, first));
  const RelativePose &to_first = from_start_[first], &to_second = from_start_[second];
  const SE3 motion = to_first.first_from_second.inverse() * to_second.first_from_second;
  // What the part up to the first view contributes is taken out of the whole.
  const ProductJacobians j(to_first.first_from_second, motion);
  const Matrix6d rest = to_second.covariance - j.first * to_first.covariance * j.first.transpose();
  const Matrix6d back = j.second.transpose();  // of a rotation twice: its inverse
  return {motion, back * rest * back.transpose()};
}

}  // namespace plumbline
