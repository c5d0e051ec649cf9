// The summary of a set of errors that every evaluation reports.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "plumbline/export.h"

namespace plumbline::eval {

/// In the unit of the values. All zero for no values.
struct Statistics {
  std::size_t count = 0;
  double rmse = 0, mean = 0, median = 0, std = 0, min = 0, max = 0;
};

/// `std` is the population's (divided by the count) and the median of an even count is the mean of the middle two, as
/// NumPy has them.
PLUMBLINE_EXPORT Statistics statistics(std::span<const double> values);

}  // namespace plumbline::eval
