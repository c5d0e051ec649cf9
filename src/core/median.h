// The middle of a list.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace plumbline {

/// The value that the share of the list lies below; 0 of none.
inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto at = std::min(values.size() - 1, static_cast<std::size_t>(share * static_cast<double>(values.size())));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
  return values[at];
}

/// Of an even number the upper of the two in the middle; 0 of none.
inline double median(std::vector<double> values) { return quantile(std::move(values), 0.5); }

}  // namespace plumbline
