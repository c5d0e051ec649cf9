#include "eval/rigid_alignment.h"

#include <Eigen/Geometry>

namespace plumbline::eval {

SE3 rigid_alignment(const Eigen::Matrix3Xd& source, const Eigen::Matrix3Xd& target) {
  const Eigen::Matrix4d t = Eigen::umeyama(source, target, false);
  return {t.topLeftCorner<3, 3>(), t.topRightCorner<3, 1>()};
}

}  // namespace plumbline::eval
