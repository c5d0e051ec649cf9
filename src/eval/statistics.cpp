#include "plumbline/statistics.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace plumbline::eval {
namespace {

double median(std::span<const double> values) {
  std::vector<double> order(values.begin(), values.end());
  const auto middle = order.begin() + static_cast<std::ptrdiff_t>(order.size() / 2);
  std::nth_element(order.begin(), middle, order.end());
  if (order.size() % 2 == 1) return *middle;
  return (*middle + *std::max_element(order.begin(), middle)) / 2;
}

}  // namespace

Statistics statistics(std::span<const double> values) {
  if (values.empty()) return {};
  Statistics s;
  s.count = values.size();
  const double n = static_cast<double>(values.size());
  double sum = 0, squares = 0;
  for (const double v : values) {
    sum += v;
    squares += v * v;
  }
  s.mean = sum / n;
  s.rmse = std::sqrt(squares / n);
  double deviations = 0;
  for (const double v : values) deviations += (v - s.mean) * (v - s.mean);
  s.std = std::sqrt(deviations / n);
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  s.min = *low;
  s.max = *high;
  s.median = median(values);
  return s;
}

}  // namespace plumbline::eval
