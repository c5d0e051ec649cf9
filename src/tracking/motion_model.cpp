#include "tracking/motion_model.h"

#include <cmath>

namespace plumbline {

MotionModel::MotionModel(double sigma, double memory)
    : sigma_(sigma), memory_(memory), variance_(sigma * sigma * Eigen::Matrix3d::Identity()) {}

PositionPrediction MotionModel::predict(const Eigen::Vector3d& previous, double seconds) const {
  const double kept = memory_ > 0 ? std::exp(-seconds / memory_) : 0;
  const Eigen::Matrix3d variance =
      kept * kept * variance_ + (1 - kept * kept) * sigma_ * sigma_ * Eigen::Matrix3d::Identity();
  return {previous + kept * seconds * velocity_, seconds * seconds * variance};
}

void MotionModel::observe(const Eigen::Vector3d& previous, const Eigen::Vector3d& position,
                          const Eigen::Matrix3d& covariance, double seconds) {
  velocity_ = (position - previous) / seconds;
  variance_ = covariance / (seconds * seconds);
}

Eigen::Matrix3d SteadyTurn::predict(const Eigen::Matrix3d& previous, double seconds) const {
  return previous * so3::exp(seconds * rate_);
}

void SteadyTurn::observe(const Eigen::Matrix3d& previous, const Eigen::Matrix3d& rotation, double seconds) {
  rate_ = so3::log(previous.transpose() * rotation) / seconds;
}

}  // namespace plumbline
