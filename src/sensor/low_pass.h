// Second-order Butterworth low-pass, as orientation filters use it.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace plumbline {

/// Of N numbers at a time. For the first `tau` seconds the output is the mean of what came; from there on the filter
/// runs from that mean (Laidig and Seel 2023, §3.2), so that it needs no time to settle.
template <int N>
class LowPass {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;

  /// `tau`: seconds, of a first-order low-pass with the same cut-off frequency (their equation 4); `interval`: between
  /// two samples. A tau below the interval filters nothing.
  LowPass(double tau, double interval) {
    constexpr double kPi = std::numbers::pi, kRoot2 = std::numbers::sqrt2;
    passes_ = !(tau > interval);
    if (passes_) return;
    warm_up_ = static_cast<std::size_t>(std::ceil(tau / interval));
    const double cutoff = std::min(kRoot2 / (2 * kPi * tau), 0.45 / interval), c = std::tan(kPi * cutoff * interval),
                 d = c * c + kRoot2 * c + 1;
    b0_ = c * c / d;
    a1_ = 2 * (c * c - 1) / d;
    a2_ = (1 - kRoot2 * c + c * c) / d;
  }

  const Vector& update(const Vector& x) {
    if (passes_) return output_ = x;
    if (count_ < warm_up_) {
      ++count_;
      output_ += (x - output_) / static_cast<double>(count_);
      settle(output_);
      return output_;
    }
    output_ = b0_ * x + first_;
    first_ = 2 * b0_ * x - a1_ * output_ + second_;
    second_ = b0_ * x - a2_ * output_;
    return output_;
  }

  const Vector& output() const { return output_; }

  /// As if `x` had come for ever.
  void settle(const Vector& x) {
    output_ = x;
    first_ = (1 - b0_) * x;
    second_ = (b0_ - a2_) * x;
  }
  void skip_warm_up() { count_ = warm_up_; }
  std::size_t warm_up() const { return warm_up_; }

 private:
  bool passes_ = false;
  std::size_t warm_up_ = 0, count_ = 0;
  double b0_ = 1, a1_ = 0, a2_ = 0;
  Vector output_ = Vector::Zero(), first_ = Vector::Zero(), second_ = Vector::Zero();
};

/// Forward and backward, without delay. Either way the filter starts from the mean over the first `tau`.
template <int N>
std::vector<Eigen::Matrix<double, N, 1>> low_pass_both_ways(std::vector<Eigen::Matrix<double, N, 1>> values, double tau,
                                                            double interval) {
  using Vector = Eigen::Matrix<double, N, 1>;
  for (int way = 0; way < 2; ++way) {
    LowPass<N> filter(tau, interval);
    const std::size_t count = std::min(values.size(), std::max<std::size_t>(1, filter.warm_up()));
    Vector mean = Vector::Zero();
    for (std::size_t i = 0; i < count; ++i) mean += values[i] / static_cast<double>(count);
    filter.skip_warm_up();
    filter.settle(mean);
    for (Vector& value : values) value = filter.update(value);
    std::reverse(values.begin(), values.end());
  }
  return values;
}

}  // namespace plumbline
