// Which of many measurements can be true together: the largest set in which every two agree (pairwise consistency
// maximisation: Mangelson, Dominic, Eustice, Vasudevan, ICRA 2018).
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace plumbline {

/// Indices of a largest set found of 0 … count − 1 in which every two are consistent, ascending. Greedy from every
/// start, those with many partners first: the same set on every run, in the square to the cube of the number.
std::vector<std::size_t> consistent_set(std::size_t count,
                                        const std::function<bool(std::size_t a, std::size_t b)>& are_consistent);

}  // namespace plumbline
